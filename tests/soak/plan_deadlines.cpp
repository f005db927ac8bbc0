// SPDX-License-Identifier: Apache-2.0
// How long a request through a door may wait, by the settings in force; doors to other devices.
#include <algorithm>
#include <utility>

#include "soak/plan.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

void set_deadlines(const SoakPlan& plan, Door& door) {
  const gateway::Settings& settings = plan.settings;
  Duration longest{0};
  for (const std::size_t bus : door.buses) {
    longest = std::max(longest, settings.buses[bus].timing.response_timeout);
    for (std::size_t index = 0; index < settings.devices.size(); ++index) {
      const drive::Device& device = settings.devices[index];
      if (static_cast<std::size_t>(device.bus) == bus && !plan.absent.devices[index]) {
        longest = std::max(longest, device.timing.response_wait +
                                        std::max(device.timing.response_timeout,
                                                 device.profile.slow.front().response_timeout));
      }
    }
  }
  const auto set = door.route ? settings.routes[*door.route].deadline : std::nullopt;
  door.write_deadline = set.value_or(3 * longest + 500ms);
  door.read_deadline = set.value_or(std::max<Duration>(5s, 3 * longest + 500ms));
}

void add_twin(SoakPlan& plan, Door door, std::size_t device) {
  door.device = device;
  door.buses = {static_cast<std::size_t>(plan.settings.devices[device].bus)};
  door.absent = true;
  plan.doors.push_back(std::move(door));
}

}  // namespace mbgate::soak
