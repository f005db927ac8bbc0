// SPDX-License-Identifier: Apache-2.0
#include "routing/route_table.hpp"

#include "modbus/rtu.hpp"

namespace mbgate::routing {

RouteTable::RouteTable(std::span<const ListenerKind> listeners, std::span<const Route> routes) {
  for (std::size_t listener = 0; listener < listeners.size(); ++listener) {
    Units units;
    units.fill(kNone);
    if (listeners[listener].bus) {
      add_transparent(listeners[listener], units);
    } else {
      for (const Route& route : routes) {
        if (!route.listener) {
          add(route, units);
        }
      }
      for (const Route& route : routes) {
        if (route.listener == ListenerId(static_cast<std::uint32_t>(listener))) {
          add(route, units);
        }
      }
    }
    listeners_.push_back(units);
  }
}

void RouteTable::add_transparent(const ListenerKind& kind, Units& units) {
  Route route;
  route.buses = {*kind.bus};
  route.first_unit = route.first_address = 1;
  route.last_unit = modbus::kMaxDeviceAddress;
  add(route, units);
  if (kind.broadcast) {
    Route broadcast;
    broadcast.buses = {*kind.bus};
    broadcast.broadcast_reply = kind.broadcast_reply;
    add(broadcast, units);
  }
}

void RouteTable::add(const Route& route, Units& units) {
  const auto index = static_cast<Index>(routes_.size());
  routes_.push_back(route);
  for (std::size_t unit = route.first_unit; unit <= route.last_unit; ++unit) {
    units.at(unit) = index;
  }
}

const Route* RouteTable::find(ListenerId listener, std::uint8_t unit) const {
  const Index index = listeners_[static_cast<std::size_t>(listener)][unit];
  return index == kNone ? nullptr : &routes_[static_cast<std::size_t>(index)];
}

}  // namespace mbgate::routing
