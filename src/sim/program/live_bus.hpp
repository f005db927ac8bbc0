// SPDX-License-Identifier: Apache-2.0
// A virtual bus on a pty, or behind a TCP port like that of a serial device server. What is read
// there goes onto the wire, and what the wire delivers is written there. Part of the simulator's
// shell; the instants are those of the steady clock.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "sim/program/pty.hpp"
#include "sim/program/settings.hpp"
#include "sim/program/tcp_port.hpp"
#include "sim/wire/request_framer.hpp"
#include "sim/wire/tcp_bus.hpp"
#include "sim/wire/wire.hpp"

namespace mbgate::sim {

class LiveBus {
 public:
  explicit LiveBus(const BusSettings& settings);

  /// Creates pty and link, or listens. Returns an error text if that fails. A port that the kernel
  /// chose stays the same from then on.
  std::optional<std::string> connect();
  /// The adapter vanishes; the drives keep their state.
  void disconnect();
  /// The connected pty, nullptr if there is none.
  [[nodiscard]] const Pty* pty() const { return pty_ ? &*pty_ : nullptr; }
  /// The descriptors to be watched for input.
  [[nodiscard]] std::vector<int> descriptors() const;
  void release_exclusive() const;

  void handle_readable(Instant now);
  void handle_time(Instant now);
  [[nodiscard]] std::optional<Instant> next_event() const;

  /// "bus line-a ./line-a (/dev/pts/7)", "bus line-b 127.0.0.1:40123".
  [[nodiscard]] std::string introduction() const;
  /// "bus line-a: frames 3, answers 3, silence violations 0, collisions 0, bad CRC 0".
  [[nodiscard]] std::string counters_text() const;

 private:
  std::optional<std::string> listen();
  std::vector<std::uint8_t> receive();
  /// Takes over the mode of the client's port. What a pty does not keep is set as on the drives.
  void read_mode();

  std::string name_;
  std::filesystem::path link_;
  std::optional<ListenAddress> address_;  ///< where it listens, instead of the link
  RequestFramer framer_;
  Wire wire_;
  std::optional<Pty> pty_;
  std::optional<TcpPort> port_;
};

/// Simulated drives behind a listening socket. Part of the simulator's shell, with the same
/// interface as LiveBus.
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
