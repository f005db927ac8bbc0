// SPDX-License-Identifier: Apache-2.0
// Drives on Ethernet: Modbus TCP requests of any number of connections, split, coalesced and
// pipelined as they come, go to the device with their unit identifier. A device handles one request
// after the other; several devices work in parallel. Pure: instants are handed in.
//
//   if (!bus.receive(connection, bytes, now)) { close it }
//   while (auto at = bus.next_event()) { for (auto& response : bus.advance(*at)) { send it } }
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <vector>

#include "modbus/mbap.hpp"
#include "sim/drives/device.hpp"

namespace mbgate::sim {

using ConnectionId = std::uint64_t;

struct TcpResponse {
  Instant at;
  ConnectionId connection;
  modbus::MbapBytes bytes;
};

struct TcpBusCounters {
  std::uint64_t requests = 0;  ///< including those for units without a device
  std::uint64_t answers = 0;
  friend bool operator==(const TcpBusCounters&, const TcpBusCounters&) = default;
};

class TcpBus {
 public:
  TcpBus(const std::vector<DeviceSettings>& devices, bool paced);

  /// False: what came cannot be Modbus TCP, so the connection has to be closed.
  [[nodiscard]] bool receive(ConnectionId connection, modbus::Bytes bytes, Instant now);
  /// The connection is closed; responses to it are dropped.
  void forget(ConnectionId connection);
  void forget_all();
  /// When the next response is due.
  [[nodiscard]] std::optional<Instant> next_event() const;
  /// The responses that are due by `now`, in order.
  std::vector<TcpResponse> advance(Instant now);

  [[nodiscard]] const TcpBusCounters& counters() const { return counters_; }
  /// The device with the unit identifier, nullptr if there is none.
  [[nodiscard]] Device* device(std::uint8_t unit);

 private:
  struct Served {
    Device device;
    Instant free_at{};  ///< when it has finished all its requests
  };

  void serve(ConnectionId connection, const modbus::MbapAdu& adu, Instant now);

  std::vector<Served> devices_;
  std::map<ConnectionId, std::vector<std::uint8_t>> streams_;
  std::vector<TcpResponse> due_;  ///< the earliest first
  TcpBusCounters counters_;
};

}  // namespace mbgate::sim
