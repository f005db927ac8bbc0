// SPDX-License-Identifier: Apache-2.0
// Simulated drives behind a listening socket. Part of the simulator's shell, with the same
// interface as LiveBus.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/program/settings.hpp"
#include "sim/program/tcp_port.hpp"
#include "sim/wire/tcp_bus.hpp"

namespace mbgate::sim {

class LiveTcpBus {
 public:
  explicit LiveTcpBus(const BusSettings& settings);

  /// Listens. Returns an error text if that fails. A port that the kernel chose stays the same from
  /// then on.
  std::optional<std::string> connect();
  /// The cable is pulled: stops listening and closes all connections. The drives keep their state.
  void disconnect();
  [[nodiscard]] std::vector<int> descriptors() const;

  void handle_readable(Instant now);
  void handle_time(Instant now);
  [[nodiscard]] std::optional<Instant> next_event() const { return bus_.next_event(); }
  static void release_exclusive() {}

  /// "bus cell 127.0.0.1:40123".
  [[nodiscard]] std::string introduction() const;
  /// "bus cell: requests 3, answers 3".
  [[nodiscard]] std::string counters_text() const;

 private:
  std::string name_;
  ListenAddress address_;
  TcpBus bus_;
  std::optional<TcpPort> port_;
};

}  // namespace mbgate::sim
