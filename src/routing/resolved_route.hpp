// SPDX-License-Identifier: Apache-2.0
// A route with what it leads to: the device, or the devices that hear a broadcast.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "drive/device.hpp"
#include "modbus/pdu.hpp"
#include "routing/route.hpp"

namespace mbgate::routing {

/// The devices of one bus that a broadcast is meant for. None: no devices are configured, and the
/// broadcast is sent in the standard form.
struct BusDevices {
  BusId bus;
  std::vector<const drive::Device*> devices;
};

struct ResolvedRoute {
  Route route;
  const drive::Device* device = nullptr;       ///< set: the rules of its profile apply
  std::vector<BusDevices> devices_of_buses{};  ///< of a broadcast
  /// Set: only this form is sent, because the client has addressed the broadcast address of a
  /// drive's own form.
  std::optional<drive::BroadcastForm> only_form{};
  /// Set: every unit of the bus is the one device that has this address.
  std::optional<std::uint8_t> one_address{};

  [[nodiscard]] bool is_broadcast() const { return !devices_of_buses.empty(); }
};

// Decides for each request whether its client may make it on this route; a denied one gets
// exception 01.

/// What a client may do, by its address on its listener.
struct ClientRights {
  bool read_only = false;
};

/// What does not allow a request.
enum class Denial : std::uint8_t { functions, read_only_client, read_only_route, no_broadcast };

/// Function codes, sub-functions of 08 (21 never), read-only routes and clients; broadcasts are 05,
/// 06, 15, 16 only. Nothing if it is allowed.
[[nodiscard]] std::optional<Denial> denial_of(const ResolvedRoute& resolved, ClientRights rights,
                                              const modbus::Pdu& pdu);

}  // namespace mbgate::routing
