// SPDX-License-Identifier: Apache-2.0
// Who may write to a device, and the failsafe writes that it gets when the client that counts has
// gone.
#pragma once

#include <cstdint>
#include <vector>

#include "bus/instant.hpp"
#include "modbus/request.hpp"
#include "routing/client_address.hpp"

namespace mbgate::gateway {

enum class WriterRule : std::uint8_t {
  any,
  first,  ///< the client that wrote last owns writing for `writer_hold`
  listed  ///< the clients in `writers` and no others
};

struct DeviceGuard {
  WriterRule writer = WriterRule::any;
  routing::ClientList writers;
  bus::Duration writer_hold = std::chrono::seconds(5);
  /// Whose leaving and silence counts for the failsafe writes; empty: that of the client that wrote
  /// to the device last.
  routing::ClientList failsafe_clients;
  /// Failsafe writes, with the function code that the device takes.
  std::vector<modbus::Request> failsafe;
  bus::Duration quiet{0};  ///< 0: silence alone is no reason
  /// A client that counts has gone when it has asked the device nothing for so long.
  bus::Duration failsafe_grace = std::chrono::seconds(1);
  bool failsafe_on_exit = false;  ///< also when the gateway stops, if clients have written
};

/// Clients in the network get `weight` turns where others get one.
struct ClientWeight {
  routing::Network network;
  unsigned weight = 1;
  friend bool operator==(const ClientWeight&, const ClientWeight&) = default;
};

}  // namespace mbgate::gateway
