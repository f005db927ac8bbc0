// SPDX-License-Identifier: Apache-2.0
// The connections of all clients, by the machine's client number. Counts also the connections that
// the machine has closed and that still send what was queued.
#pragma once

#include <boost/asio/io_context.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <unordered_map>
#include <vector>

#include "io/clients/hangup_watch.hpp"
#include "io/clients/tcp_connection.hpp"

namespace mbgate::io {

class ClientConnections {
 public:
  ClientConnections(boost::asio::io_context& context, ConnectionEvents& events);
  ClientConnections(const ClientConnections&) = delete;  // its parts refer to each other
  ClientConnections& operator=(const ClientConnections&) = delete;

  /// Adds a connection under a new number. It reports nothing before TcpConnection::start().
  gateway::ClientId add(ClientSocket socket);
  /// nullptr if it has ended or was closed.
  [[nodiscard]] TcpConnection* find(gateway::ClientId client) const;
  /// Reads each once, as after a pause: what waited in them while nobody read is reported before
  /// what comes from now on.
  void read_all();
  /// The connection has ended by itself.
  void note_disconnected(gateway::ClientId client) { connections_.erase(client); }
  /// TcpConnection::abort(); nothing if there is no such connection.
  std::optional<modbus::Bytes> abort(gateway::ClientId client);
  /// TcpConnection::close(), if there is one.
  void close(gateway::ClientId client, bus::Duration limit);
  void close_all(bus::Duration limit);
  /// A closed connection has reported its end.
  void note_closed() { --closing_; }
  [[nodiscard]] bool empty() const { return connections_.empty(); }
  /// Are there closed connections that still send what was queued?
  [[nodiscard]] bool are_closing() const { return closing_ > 0; }

 private:
  HangupWatch hangups_;
  ConnectionContext context_;
  [[nodiscard]] std::vector<gateway::ClientId> all() const;

  std::unordered_map<gateway::ClientId, std::shared_ptr<TcpConnection>> connections_;
  std::uint64_t next_client_ = 0;
  std::size_t closing_ = 0;
};

}  // namespace mbgate::io
