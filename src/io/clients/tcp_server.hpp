// SPDX-License-Identifier: Apache-2.0
// Accepts the connections of one listening socket. If there are no descriptors or no memory left
// for clients, new connections are closed, so that their clients notice, and the server goes on.
// Some descriptors are kept for other uses.
//
// To change
// - how fast new connections are accepted: tcp_server.
// - connections that the machine has closed: client_connections, tcp_connection.
// - file descriptors and memory that are reserved for the gateway itself: resources, used by
//   tcp_server and app/control/control_doors.
// - writes that waited until their connection was accepted: how long: tcp_server; which are too
//   old: gateway/clients/client_session.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/system/error_code.hpp>
#include <memory>
#include <vector>

#include "bus/instant.hpp"
#include "gateway/settings.hpp"
#include "routing/client_address.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::io {

/// IPv4 as IPv6.
routing::ClientAddress address_of(const boost::asio::ip::tcp::endpoint& peer);

struct AcceptedClient {
  boost::asio::ip::tcp::socket socket;
  boost::asio::ip::tcp::endpoint peer;
  /// What it has sent already came no earlier; Instant::min(): perhaps before this process.
  bus::Instant connected = bus::Instant::min();
};

class AcceptEvents {
 public:
  virtual ~AcceptEvents() = default;
  virtual void client_accepted(gateway::ListenerId listener, AcceptedClient client) = 0;
  /// Accepting failed for lack of descriptors or memory; it is tried again after a pause.
  virtual void accept_failed(gateway::ListenerId listener,
                             const boost::system::error_code& error) = 0;
};

class TcpServer {
 public:
  /// The acceptor listens already and is non-blocking. Descriptors from `end` on are not for
  /// clients.
  TcpServer(boost::asio::io_context& context, gateway::ListenerId listener,
            boost::asio::ip::tcp::acceptor acceptor, AcceptEvents& events, int end);
  TcpServer(const TcpServer&) = delete;
  TcpServer& operator=(const TcpServer&) = delete;
  ~TcpServer() = default;

  /// Accepts the connections that are already waiting, without blocking.
  void accept_waiting();
  /// Accepts new connections from now on.
  void start();
  /// Accepts no more.
  void stop();
  void set_end(int end) { end_ = end; }
  [[nodiscard]] gateway::ListenerId listener() const { return listener_; }

 private:
  enum class Outcome : std::uint8_t { accepted, none_waiting, failed };

  boost::asio::awaitable<void> run();
  Outcome accept_one(bool is_start);
  /// 0, or the error number that says why a client with this descriptor is not let in.
  [[nodiscard]] int objection(int socket) const;
  Outcome take(sys::UniqueFd socket, const boost::asio::ip::tcp::endpoint& peer, bool is_start);
  /// With the spare descriptor, accepts and closes what is waiting.
  void shed();

  boost::asio::io_context& context_;
  gateway::ListenerId listener_;
  boost::asio::ip::tcp::acceptor acceptor_;
  boost::asio::steady_timer pause_;
  AcceptEvents& events_;
  int end_;
  sys::UniqueFd spare_;
};

/// The sockets that accept clients. One listener may have several.
class ServerSet {
 public:
  ServerSet(boost::asio::io_context& context, AcceptEvents& events)
      : context_(context), events_(events) {}

  /// Descriptors from `end` on are not for clients. Once start() was called it accepts at once.
  void add(gateway::ListenerId listener, boost::asio::ip::tcp::acceptor acceptor, int end);
  /// Closes the sockets of this listener: no more clients are accepted on them.
  void remove(gateway::ListenerId listener);
  void set_end(int end);
  /// Accepts the connections that are already waiting on all of them, then new ones.
  void start();
  void stop();

 private:
  boost::asio::io_context& context_;
  AcceptEvents& events_;
  std::vector<std::unique_ptr<TcpServer>> servers_;
  bool started_ = false;
};

}  // namespace mbgate::io
