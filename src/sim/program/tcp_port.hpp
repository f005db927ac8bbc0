// SPDX-License-Identifier: Apache-2.0
// A listening TCP socket and its connections. Nothing here blocks. Part of the simulator's shell.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "modbus/bytes.hpp"
#include "modbus/result.hpp"
#include "sim/wire/tcp_bus.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::sim {

/// Where a simulated bus listens: an IPv4 address and a port, "127.0.0.1:1502".
struct ListenAddress {
  std::string host = "127.0.0.1";
  std::uint16_t port = 0;  ///< 0: the kernel chooses

  static std::optional<ListenAddress> parse(std::string_view text);
  [[nodiscard]] std::string text() const { return host + ':' + std::to_string(port); }
  friend bool operator==(const ListenAddress&, const ListenAddress&) = default;
};

class TcpPort {
 public:
  /// At most `most_connections` at a time; further ones are closed at once. Error: a sentence that
  /// names the address and what is wrong.
  static Result<TcpPort, std::string> open(const ListenAddress& address,
                                           std::size_t most_connections);

  /// Where it listens, the port that the kernel chose included.
  [[nodiscard]] const ListenAddress& address() const { return address_; }
  /// The descriptors to be watched for input.
  [[nodiscard]] std::vector<int> descriptors() const;

  struct Received {
    ConnectionId connection;
    std::vector<std::uint8_t> bytes;
    bool closed;  ///< by the other side, after these bytes
  };
  /// Accepts new connections, and returns what all of them have sent since the last call.
  std::vector<Received> receive();
  /// A connection that does not take all of it at once is regarded as dead and closed; the next
  /// receive() reports that.
  void send(ConnectionId connection, modbus::Bytes bytes);
  /// To all connections.
  void send(modbus::Bytes bytes);
  void close(ConnectionId connection) { connections_.erase(connection); }

 private:
  TcpPort(sys::UniqueFd listener, ListenAddress address, std::size_t most_connections);
  void accept();

  sys::UniqueFd listener_;
  ListenAddress address_;
  std::size_t most_connections_;
  std::map<ConnectionId, sys::UniqueFd> connections_;
  ConnectionId next_ = 1;
};

}  // namespace mbgate::sim
