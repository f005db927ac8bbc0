// SPDX-License-Identifier: Apache-2.0
#include "explore/plant.hpp"

#include <algorithm>
#include <functional>

namespace mbgate::explore {
namespace {

gateway::Settings usual() {
  gateway::Settings settings;
  settings.status_unit.reset();
  settings.listeners.emplace_back().name = "clients";
  settings.listeners[0].max_requests_per_second = 0;
  bus::BusSettings& line = settings.buses.emplace_back();
  line.name = "line";
  line.line.echo = false;
  line.timing.response_timeout = 250ms;  // the longest of the bus, as of its devices
  for (std::uint8_t address = 1; address <= kDevices; ++address) {
    drive::Device& device = settings.devices.emplace_back();
    device.name = "device-" + std::to_string(address);
    device.address = address;
    device.timing.response_timeout = 250ms;
    // Three transmissions in a row would have to be lost.
    device.timing.offline_after = 0;
    device.profile.stops.push_back({.address = kCommand, .value = kStopValue});
  }
  routing::Route& route = settings.routes.emplace_back();
  route.first_unit = 1;
  route.last_unit = kDevices;
  route.first_address = 1;
  route.buses = {drive::BusId{0}};
  route.deadline = 60s;  // none that is ever reached
  return settings;
}

Plant plant(std::string_view name, std::string_view what,
            const std::function<void(gateway::Settings&)>& change) {
  Plant made{name, what, usual()};
  change(made.settings);
  return made;
}

/// Both devices are alike, so that it does not matter which one is asked first.
template <typename Change>
auto each_device(Change change) {
  return [change](gateway::Settings& settings) { std::ranges::for_each(settings.devices, change); };
}

std::vector<Plant> make_plants() {
  return {
      plant("usual", "one retry, quarantine as long as the timeout, no deadline is reached",
            [](gateway::Settings&) {}),
      plant("no-retries", "retries = 0",
            each_device([](drive::Device& device) { device.timing.retries = 0; })),
      plant("cache", "cache = 300ms, retries = 1",
            each_device([](drive::Device& device) { device.cache = 300ms; })),
      plant("offline", "offline_after = 1, retries = 0", each_device([](drive::Device& device) {
              device.timing.retries = 0;
              device.timing.offline_after = 1;
            })),
      plant("deadlines", "deadlines by default",
            [](gateway::Settings& settings) { settings.routes.front().deadline.reset(); }),
      plant("deadline", "deadline = 400ms",
            [](gateway::Settings& settings) { settings.routes.front().deadline = 400ms; }),
      plant("echo", "echo = auto",
            [](gateway::Settings& settings) { settings.buses.front().line.echo.reset(); }),
  };
}

}  // namespace

const std::vector<Plant>& plants() {
  static const std::vector<Plant> all = make_plants();
  return all;
}

const Plant* find_plant(std::string_view name) {
  const auto found = std::ranges::find(plants(), name, &Plant::name);
  return found == plants().end() ? nullptr : &*found;
}

}  // namespace mbgate::explore
