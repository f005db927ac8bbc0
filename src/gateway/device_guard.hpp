// SPDX-License-Identifier: Apache-2.0
// Who may write to a device, and the failsafe writes that it gets when no such client is left.
#pragma once

#include <cstdint>
#include <vector>

#include "bus/instant.hpp"
#include "modbus/request.hpp"
#include "routing/client_list.hpp"

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
  /// Whose leaving and silence counts for the failsafe writes; empty: every client's that may write
  /// to the device.
  routing::ClientList failsafe_clients;
  /// Failsafe writes, with the function code that the device takes. They are sent once, started in
  /// order, as stops, when the last client that may write to the device has disconnected, or when
  /// all of them have been silent for `quiet`.
  std::vector<modbus::Request> failsafe;
  bus::Duration quiet{0};  ///< 0: silence alone is no reason
  bool failsafe_on_exit =
      false;  ///< also when the gateway stops, if such a client may have written
};

/// Clients in the network get `weight` turns where others get one.
struct ClientWeight {
  routing::Network network;
  unsigned weight = 1;
  friend bool operator==(const ClientWeight&, const ClientWeight&) = default;
};

}  // namespace mbgate::gateway
