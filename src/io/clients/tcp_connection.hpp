// SPDX-License-Identifier: Apache-2.0
// The socket of one client. It reports bytes, FIN and the end of the connection, and sends each ADU
// with one send() as long as the client takes it. An idle connection has no buffer: all connections
// are read into one shared buffer.
#pragma once

#include <array>
#include <boost/asio/awaitable.hpp>
#include <boost/asio/generic/stream_protocol.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <list>
#include <memory>
#include <optional>

#include "gateway/client.hpp"
#include "gateway/limits.hpp"
#include "io/clients/hangup_watch.hpp"
#include "modbus/bytes.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::io {

/// Of a client: a TCP socket, or the end of a pair whose other end speaks TLS with the client.
using ClientSocket = boost::asio::generic::stream_protocol::socket;

class ConnectionEvents {
 public:
  virtual ~ConnectionEvents() = default;
  /// `unread`: how many more bytes are in the socket. Without bytes: reading was resumed and there
  /// was nothing to read.
  virtual void client_bytes(gateway::ClientId client, modbus::Bytes bytes, std::size_t unread) = 0;
  /// The oldest ADU for which send() returned `queued` has been written.
  virtual void client_sent(gateway::ClientId client) = 0;
  /// The client has sent FIN. Called when the FIN is read; before that also once if it is noticed
  /// while reading is paused, when bytes before it are still unread.
  virtual void client_half_closed(gateway::ClientId client) = 0;
  /// The connection has ended by itself; its socket is closed. `bytes`: what it had sent before,
  /// read when it had ended already.
  virtual void client_disconnected(gateway::ClientId client, modbus::Bytes bytes) = 0;
  /// After close(): the socket is closed.
  virtual void client_closed(gateway::ClientId client) = 0;
};

/// How many bytes have come and were not read yet.
std::size_t unread_bytes(int socket);

using ReadBuffer = std::array<std::uint8_t, gateway::kClientLastSize>;

/// What the connections of one io thread share.
struct ConnectionContext {
  boost::asio::io_context& io;
  HangupWatch& hangups;
  ConnectionEvents& events;
  ReadBuffer buffer{};
};

class TcpConnection : public std::enable_shared_from_this<TcpConnection> {
 public:
  enum class SendOutcome : std::uint8_t { sent, queued, failed };

  TcpConnection(ConnectionContext& context, gateway::ClientId client, ClientSocket socket);

  /// Reports bytes and FIN until pause().
  void start();
  /// Reads no more, but still reports FIN and reset. False if they cannot be watched: then the
  /// connection must be given up.
  [[nodiscard]] bool pause();
  void resume();
  /// Reports what can be read, or that nothing can; nothing while reading is paused.
  void read_waiting();
  /// `failed`: the connection is broken, and nothing more is reported.
  SendOutcome send(const modbus::MbapBytes& adu);
  /// Sends what is queued, then FIN, and closes when the client has closed too, after `limit` at
  /// the latest. If the socket were closed at once with unread bytes, the kernel would reset the
  /// connection, and the last answers could be lost. Only client_closed() is reported from now on,
  /// perhaps from within this call.
  void close(bus::Duration limit);
  /// Closes at once and reports nothing. Returns what had come and was not read, until something
  /// else is read: a client that has gone may have sent a stop.
  modbus::Bytes abort();
  /// What it sends comes by way of another thread.
  void set_relayed() { relayed_ = true; }
  [[nodiscard]] bool is_relayed() const { return relayed_; }
  /// From the hang-up watch.
  void handle_hangup(Hangup hangup);

 private:
  static boost::asio::awaitable<void> read_loop(std::shared_ptr<TcpConnection> self);
  static boost::asio::awaitable<void> write_loop(std::shared_ptr<TcpConnection> self);
  static boost::asio::awaitable<void> discard_until_fin(std::shared_ptr<TcpConnection> self);
  void read_once();
  modbus::Bytes read_rest(std::size_t have);
  bool write_queued();
  void start_writing();
  void handle_fin();
  void disconnect();
  void close_socket();
  void finish();
  void stop_watching();

  ConnectionContext& context_;
  gateway::ClientId client_;
  ClientSocket socket_;
  std::list<modbus::MbapBytes> outbox_;
  std::size_t written_ = 0;  ///< bytes of the first ADU of the outbox
  std::optional<boost::asio::steady_timer> closing_;
  bool reading_ = false;  ///< read_loop runs
  bool writing_ = false;  ///< write_loop runs
  bool paused_ = false;
  bool watched_ = false;
  bool relayed_ = false;
  bool answered_ = false;      ///< something was sent
  bool fin_seen_ = false;      ///< read up to the FIN
  bool fin_reported_ = false;  ///< noticed while paused
};

}  // namespace mbgate::io
