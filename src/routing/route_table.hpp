// SPDX-License-Identifier: Apache-2.0
// From listener and unit identifier to the route, in one look-up.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "routing/route.hpp"

namespace mbgate::routing {

/// What the table must know of a listener.
struct ListenerKind {
  std::optional<BusId> bus;  ///< set: transparent
  bool broadcast = false;
  BroadcastReply broadcast_reply = BroadcastReply::echo;
};

class RouteTable {
 public:
  /// Transparent listeners pass units 1-247 to their bus unchanged, 0 if they broadcast, and
  /// nothing else. Routed ones know the routes that name them or no listener; a route that names
  /// the listener goes first.
  RouteTable(std::span<const ListenerKind> listeners, std::span<const Route> routes);

  /// Nothing: no path (exception 0A).
  [[nodiscard]] const Route* find(ListenerId listener, std::uint8_t unit) const;

 private:
  using Index = std::int32_t;
  static constexpr Index kNone = -1;
  using Units = std::array<Index, 256>;

  void add_transparent(const ListenerKind& kind, Units& units);
  void add(const Route& route, Units& units);

  std::vector<Route> routes_;
  std::vector<Units> listeners_;
};

}  // namespace mbgate::routing
