// SPDX-License-Identifier: Apache-2.0
#include "soak/arrangement.hpp"

#include <algorithm>

namespace mbgate::soak {
namespace {

using Places = Arrangement::Places;

Places places_of(const std::vector<bool>& absent, Random* random) {
  Places places;
  for (std::size_t place = 0; place < absent.size(); ++place) {
    if (!absent[place]) {
      places.push_back(place);
    }
  }
  for (std::size_t left = places.size(); random != nullptr && left > 1; --left) {
    std::swap(places[left - 1], places[random->below(left)]);
  }
  return places;
}

std::optional<std::size_t> find(const Places& places, std::size_t of_plan) {
  const auto found = std::ranges::find(places, of_plan);
  return found == places.end() ? std::nullopt
                               : std::optional(static_cast<std::size_t>(found - places.begin()));
}

// The number that the written settings have for it.
template <typename Id>
Id written(const Places& places, Id of_plan) {
  return Id{static_cast<std::uint32_t>(*find(places, static_cast<std::size_t>(of_plan)))};
}

}  // namespace

Arrangement::Arrangement(const SoakPlan& plan) : Arrangement(plan, nullptr) {}

Arrangement::Arrangement(const SoakPlan& plan, Random& random) : Arrangement(plan, &random) {}

Arrangement::Arrangement(const SoakPlan& plan, Random* random)
    : listeners_(places_of(plan.absent.listeners, random)),
      buses_(places_of(plan.absent.buses, random)),
      devices_(places_of(plan.absent.devices, random)) {
  settings_.status_unit = plan.settings.status_unit;
  settings_.weights = plan.settings.weights;
  settings_.tls = plan.settings.tls;
  for (const std::size_t place : listeners_) {
    auto& listener = settings_.listeners.emplace_back(plan.settings.listeners[place]);
    if (listener.bus) {
      listener.bus = written(buses_, *listener.bus);
    }
  }
  for (const std::size_t place : buses_) {
    settings_.buses.push_back(plan.settings.buses[place]);
  }
  add_devices(plan);
  add_routes(plan, places_of(plan.absent.routes, random));
  add_rules(plan);
}

// They name what is there.
void Arrangement::add_rules(const SoakPlan& plan) {
  for (std::size_t place = 0; place < plan.rules.size(); ++place) {
    if (!is_written(plan, plan.rules[place])) {
      continue;
    }
    auto& rule = settings_.rules.emplace_back(plan.settings.rules[place]);
    rule.devices.clear();
    for (const std::size_t device : plan.settings.rules[place].devices) {
      if (const auto there = find(devices_, device)) {
        rule.devices.push_back(*there);
      }
    }
    rule.listeners.clear();
    for (const gateway::ListenerId listener : plan.settings.rules[place].listeners) {
      if (!plan.absent.listeners[static_cast<std::size_t>(listener)]) {
        rule.listeners.push_back(written(listeners_, listener));
      }
    }
  }
}

void Arrangement::add_devices(const SoakPlan& plan) {
  for (const std::size_t place : devices_) {
    auto& device = settings_.devices.emplace_back(plan.settings.devices[place]);
    device.bus = written(buses_, device.bus);
    if (!plan.settings.guards.empty()) {
      settings_.guards.push_back(place < plan.settings.guards.size() ? plan.settings.guards[place]
                                                                     : gateway::DeviceGuard{});
    }
  }
}

// A route leads to what is there; a broadcast to the buses that are there.
void Arrangement::add_routes(const SoakPlan& plan, const Places& order) {
  for (const std::size_t place : order) {
    routing::Route route = plan.settings.routes[place];
    std::vector<gateway::BusId> there;
    for (const gateway::BusId it : route.buses) {
      if (!plan.absent.buses[static_cast<std::size_t>(it)]) {
        there.push_back(written(buses_, it));
      }
    }
    const bool has_listener =
        !route.listener || !plan.absent.listeners[static_cast<std::size_t>(*route.listener)];
    if (there.empty() || !has_listener || (route.device && plan.absent.devices[*route.device])) {
      continue;
    }
    route.buses = std::move(there);
    if (route.device) {
      route.first_address = plan.settings.devices[*route.device].address;
      route.device = find(devices_, *route.device);
    }
    if (route.listener) {
      route.listener = written(listeners_, *route.listener);
    }
    settings_.routes.push_back(std::move(route));
  }
}

std::optional<std::size_t> Arrangement::place_of_bus(std::size_t of_plan) const {
  return find(buses_, of_plan);
}

std::optional<std::size_t> Arrangement::place_of_device(std::size_t of_plan) const {
  return find(devices_, of_plan);
}

}  // namespace mbgate::soak
