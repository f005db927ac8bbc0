// SPDX-License-Identifier: Apache-2.0
// Clients that read near places at the same time, and do not wait for long; answers that are kept
// for long. With a chance of its own, so that plants stay those of the seed.
#include <algorithm>

#include "soak/plan.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr std::uint64_t kReadsChance = 0x5245414453ULL;

}  // namespace

void draw_reads(SoakPlan& plan, std::uint64_t seed) {
  Random random(seed ^ kReadsChance);
  for (drive::Device& device : plan.settings.devices) {
    if (device.cache > 0ms && random.chance(400)) {
      device.cache = random.duration(200ms, 2s);
    }
  }
  const bool may_merge = std::ranges::any_of(plan.settings.buses, &bus::BusSettings::merge);
  if (!random.chance(may_merge ? 500 : 100)) {
    return;
  }
  const Duration step = random.one_of<Duration>({0ms, 50ms, 200ms});
  const bool is_impatient = !plan.silence && random.chance(500);
  for (Manners& manners : plan.clients) {
    manners.near_reads = random.one_of<std::uint16_t>({0, 500, 900});
    manners.in_step = step;
    manners.patience = is_impatient && random.chance(300) ? random.duration(50ms, 400ms) : 0ms;
  }
}

}  // namespace mbgate::soak
