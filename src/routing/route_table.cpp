// SPDX-License-Identifier: Apache-2.0
#include "routing/route_table.hpp"

#include <algorithm>
#include <limits>

#include "modbus/frames.hpp"
#include "routing/device_plan.hpp"

namespace mbgate::routing {
namespace {

// Addresses that the specification reserves (Serial Line V1.02, 2.2), and some devices have all the
// same. 255 is the gateway itself.
bool is_reserved(std::uint8_t address) {
  return address > modbus::kMaxDeviceAddress && address < std::numeric_limits<std::uint8_t>::max();
}

}  // namespace

RouteTable::RouteTable(std::span<const ListenerKind> listeners, std::span<const Route> routes,
                       std::span<const drive::Device> devices)
    : devices_(devices) {
  for (std::size_t listener = 0; listener < listeners.size(); ++listener) {
    Units units{};
    if (listeners[listener].bus) {
      add_transparent(listeners[listener], units);
    } else {
      const ListenerId id{static_cast<std::uint32_t>(listener)};
      for (const auto named : {std::optional<ListenerId>(), std::optional(id)}) {
        for (const Route& route : routes) {
          if (route.listener == named) {
            add(route, units);
          }
        }
      }
    }
    guard_broadcast_address(units);
    listeners_.push_back(units);
  }
}

void RouteTable::add_transparent(const ListenerKind& kind, Units& units) {
  Route route;
  route.buses = {*kind.bus};
  route.first_unit = route.first_address = 1;
  route.last_unit = modbus::kMaxDeviceAddress;
  route.functions.change_delimiter = kind.change_delimiter;
  add(route, units);
  for (const drive::Device& device : devices_) {
    if (device.bus == *kind.bus && is_reserved(device.address)) {
      route.first_unit = route.last_unit = route.first_address = device.address;
      add(route, units);
    }
  }
  if (kind.broadcast) {
    Route broadcast;
    broadcast.buses = {*kind.bus};
    broadcast.broadcast_reply = kind.broadcast_reply;
    broadcast.broadcast_mixed = kind.broadcast_mixed;
    add(broadcast, units);
  }
}

void RouteTable::add(const Route& route, Units& units) {
  if (route.buses.empty()) {
    return;  // to all buses of a gateway that has none
  }
  ResolvedRoute& resolved = routes_.emplace_back();
  resolved.route = route;
  if (route.device) {
    resolved.device = &devices_[*route.device];
  }
  for (const drive::Device& device : devices_) {
    if (device.has_every_unit && device.bus == route.buses.front()) {
      resolved.one_address = device.address;
    }
  }
  if (route.is_broadcast()) {
    std::ranges::transform(route.buses, std::back_inserter(resolved.devices_of_buses),
                           [this](BusId bus) { return devices_on(bus); });
  }
  for (std::size_t unit = route.first_unit; unit <= route.last_unit; ++unit) {
    units.at(unit) = &resolved;
  }
}

BusDevices RouteTable::devices_on(BusId bus) const {
  BusDevices known{bus, {}};
  for (const drive::Device& device : devices_) {
    if (device.bus == bus) {
      known.devices.push_back(&device);
    }
  }
  return known;
}

// Where drives hear broadcasts at an address of their own, that is no device's: it reaches them
// all, so that only a client who may broadcast there gets a route.
void RouteTable::guard_broadcast_address(Units& units) {
  for (std::size_t unit = 0; unit < units.size(); ++unit) {
    const ResolvedRoute* resolved = units[unit];
    if (const auto form = resolved == nullptr ? std::nullopt : own_form_at(*resolved, unit)) {
      units[unit] = route_of_form(*resolved, units[0], *form);
    }
  }
}

std::optional<drive::BroadcastForm> RouteTable::own_form_at(const ResolvedRoute& resolved,
                                                            std::size_t unit) const {
  if (resolved.is_broadcast()) {
    return std::nullopt;
  }
  const std::size_t address = resolved.route.first_address + (unit - resolved.route.first_unit);
  const auto hearer = std::ranges::find_if(devices_, [&](const drive::Device& device) {
    const drive::Broadcast& rules = device.profile.broadcast;
    return device.bus == resolved.route.buses.front() && rules.has_own_form() &&
           rules.form->address == address;
  });
  return hearer == devices_.end() ? std::nullopt : hearer->profile.broadcast.form;
}

const ResolvedRoute* RouteTable::route_of_form(const ResolvedRoute& resolved,
                                               const ResolvedRoute* broadcast,
                                               drive::BroadcastForm form) {
  const BusId bus = resolved.route.buses.front();
  if (broadcast == nullptr || !broadcast->is_broadcast() ||
      std::ranges::count(broadcast->route.buses, bus) == 0) {
    return nullptr;
  }
  const Route& all = broadcast->route;
  ResolvedRoute& only = routes_.emplace_back(resolved);
  Route& route = only.route;
  if (all.access == Access::read_only) {  // both must allow it
    route.access = Access::read_only;
  }
  route.functions.allowed &= all.functions.allowed;
  route.broadcast_reply = all.broadcast_reply;
  route.broadcast_mixed = all.broadcast_mixed;
  only.devices_of_buses = {devices_on(bus)};
  only.only_form = form;
  return &only;
}

const ResolvedRoute* RouteTable::find(ListenerId listener, std::uint8_t unit) const {
  return listeners_[static_cast<std::size_t>(listener)][unit];
}

std::bitset<256> RouteTable::units(ListenerId listener) const {
  const Units& units = listeners_[static_cast<std::size_t>(listener)];
  std::bitset<256> routed;
  for (std::size_t unit = 0; unit < units.size(); ++unit) {
    routed.set(unit, units[unit] != nullptr);
  }
  return routed;
}

}  // namespace mbgate::routing
