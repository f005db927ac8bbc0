// SPDX-License-Identifier: Apache-2.0
// Finds the route for a listener and a unit identifier in one look-up.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "routing/route.hpp"

namespace mbgate::routing {

/// What the table needs to know of a listener.
struct ListenerKind {
  std::optional<BusId> bus;  ///< set: transparent
  bool broadcast = false;
  BroadcastReply broadcast_reply = BroadcastReply::echo;
  bool broadcast_mixed = false;
  bool change_delimiter = true;  ///< 08/03 passes
};

class RouteTable {
 public:
  /// Transparent listeners pass units 1-247 to their bus unchanged, 0 if they broadcast, and
  /// nothing else. Routed ones use the routes that name them or no listener; a route that names the
  /// listener takes precedence. `devices` are those of the settings and must outlive the table.
  RouteTable(std::span<const ListenerKind> listeners, std::span<const Route> routes,
             std::span<const drive::Device> devices);
  RouteTable(const RouteTable&) = delete;  // its parts refer to each other
  RouteTable& operator=(const RouteTable&) = delete;

  /// Nothing: no path (exception 0A).
  [[nodiscard]] const ResolvedRoute* find(ListenerId listener, std::uint8_t unit) const;
  /// The units that have a route on the listener.
  [[nodiscard]] std::bitset<256> units(ListenerId listener) const;

 private:
  using Units = std::array<const ResolvedRoute*, 256>;  // nullptr: no route

  void add_transparent(const ListenerKind& kind, Units& units);
  void add(const Route& route, Units& units);
  void guard_broadcast_address(Units& units);
  [[nodiscard]] BusDevices devices_on(BusId bus) const;
  [[nodiscard]] std::optional<drive::BroadcastForm> own_form_at(const ResolvedRoute& resolved,
                                                                std::size_t unit) const;
  [[nodiscard]] const ResolvedRoute* route_of_form(const ResolvedRoute& resolved,
                                                   const ResolvedRoute* broadcast,
                                                   drive::BroadcastForm form);

  std::span<const drive::Device> devices_;
  std::deque<ResolvedRoute> routes_;  // their addresses are stable
  std::vector<Units> listeners_;
};

}  // namespace mbgate::routing
