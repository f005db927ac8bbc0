// SPDX-License-Identifier: Apache-2.0
// A route with what it leads to: the device, or the devices that hear a broadcast.
#pragma once

#include <vector>

#include "drive/device.hpp"
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

}  // namespace mbgate::routing
