// SPDX-License-Identifier: Apache-2.0
// What a reload brings: the plant with other rules, with parts that are gone, in another order.
#pragma once

#include "fuzz/plant.hpp"

namespace mbgate::fuzz {

/// The two uppermost bits of a change only move everything to other places.
inline constexpr std::uint16_t kMeaningOfChange = 0x3FFF;

/// Wherever the settings name a bus.
template <typename Renumber>
void renumber_buses(gateway::Settings& settings, Renumber renumber) {
  for (auto& device : settings.devices) {
    renumber(device.bus);
  }
  for (auto& listener : settings.listeners) {
    if (listener.bus) {
      renumber(*listener.bus);
    }
  }
  for (auto& route : settings.routes) {
    std::ranges::for_each(route.buses, renumber);
  }
}

inline void remove_bus(gateway::Settings& settings, std::uint32_t gone) {
  const drive::BusId bus{gone};
  settings.buses.erase(settings.buses.begin() + gone);
  settings.devices.erase(settings.devices.begin() + gone);
  settings.guards.erase(settings.guards.begin() + gone);
  std::erase_if(settings.listeners, [&](const auto& listener) { return listener.bus == bus; });
  std::erase_if(settings.routes, [&](auto& route) {
    std::erase(route.buses, bus);
    return route.buses.empty();
  });
  const auto renumber = [&](drive::BusId& id) {
    if (bus < id) {
      id = drive::BusId{static_cast<std::uint32_t>(id) - 1};
    }
  };
  renumber_buses(settings, renumber);
  for (auto& route : settings.routes) {
    if (route.device && *route.device > gone) {
      --*route.device;
    }
  }
}

/// Everything one place further down its list; what refers to it follows.
inline void rotate(gateway::Settings& settings) {
  const std::size_t buses = settings.buses.size();
  const auto renumber = [&](drive::BusId& id) {
    id = drive::BusId{static_cast<std::uint32_t>((static_cast<std::size_t>(id) + 1) % buses)};
  };
  const auto move_on = [](auto& list) { std::rotate(list.begin(), list.end() - 1, list.end()); };
  renumber_buses(settings, renumber);
  for (auto& route : settings.routes) {
    if (route.device) {
      route.device = (*route.device + 1) % settings.devices.size();
    }
  }
  move_on(settings.buses);
  move_on(settings.devices);
  move_on(settings.guards);
  move_on(settings.listeners);
  move_on(settings.routes);
}

/// `settings` are those of a plant; each bit of `change` is one thing that is different.
inline gateway::Settings changed(gateway::Settings settings, std::uint16_t change) {
  using namespace std::chrono_literals;
  const auto chosen = [&](unsigned bit) { return ((change >> bit) & 1U) != 0; };
  auto& devices = settings.devices;
  if (chosen(0)) {
    for (auto& device : devices) {
      device.timing.response_timeout = 20ms;
      device.timing.retries = 0;
      device.timing.offline_after = 1;
    }
  }
  if (chosen(1)) {
    devices[0].word_order = drive::WordOrder::big;
  }
  if (chosen(2)) {
    devices[1].address = settings.routes[1].first_address = 5;
  }
  if (chosen(3)) {
    settings.routes[2].word_order.reset();
  }
  if (chosen(4)) {
    settings.buses[0].line.baud = modbus::Baud{38400};
  }
  if (chosen(5)) {
    settings.listeners[0].allow = {*routing::Network::parse("0.0.0.1")};
  }
  if (chosen(6)) {
    settings.listeners[0].pipeline = 1;
    settings.listeners[1].ordered = false;
  }
  if (chosen(7)) {
    settings.buses[2].outstanding = 1;
    settings.buses[1].queue = 1;
  }
  if (chosen(8)) {
    devices[0].profile.stops.clear();
    devices[0].profile.unanswered.clear();
    devices[2].name = "another";
  }
  if (chosen(9)) {
    settings.listeners[0].read_only = {*routing::Network::parse("0.0.0.0/8")};
    settings.status_unit.reset();
  }
  if (chosen(10)) {
    settings.listeners.pop_back();
  }
  if (chosen(11)) {
    remove_bus(settings, 1);
  }
  if (chosen(12)) {
    remove_bus(settings, 0);
  }
  for (unsigned places = change >> 14U; places > 0; --places) {
    rotate(settings);
  }
  return settings;
}

}  // namespace mbgate::fuzz
