// SPDX-License-Identifier: Apache-2.0
// Loopback sockets for tests: a listener on a port that the kernel chooses, and the other ends of
// connections.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <string>
#include <string_view>

#include "io/clients/listening_socket.hpp"

namespace mbgate::io {

inline gateway::ListenerSettings loopback_listener() {
  gateway::ListenerSettings listener;
  listener.name = "test";
  listener.address = "127.0.0.1";
  listener.port = 0;
  return listener;
}

/// The other end of a connection, blocking.
class TestClient {
 public:
  TestClient(boost::asio::io_context& context, const boost::asio::ip::tcp::acceptor& server)
      : TestClient(context, server.local_endpoint()) {}
  TestClient(boost::asio::io_context& context, const boost::asio::ip::tcp::endpoint& server)
      : socket_(context) {
    socket_.connect(server);
  }
  explicit TestClient(boost::asio::ip::tcp::socket accepted) : socket_(std::move(accepted)) {}

  boost::asio::ip::tcp::socket& socket() { return socket_; }
  /// False if not all of it was sent.
  [[nodiscard]] bool send(std::string_view bytes) {
    return ::send(socket_.native_handle(), bytes.data(), bytes.size(), MSG_NOSIGNAL) ==
           static_cast<ssize_t>(bytes.size());
  }
  void send_fin() { socket_.shutdown(boost::asio::ip::tcp::socket::shutdown_send); }
  /// Closes so that the peer gets a reset.
  void reset() {
    socket_.set_option(boost::asio::socket_base::linger(true, 0));
    socket_.close();
  }
  /// What has arrived; nothing waits. `ended` is set at the end of the stream.
  std::string receive(bool* ended = nullptr) {
    std::string bytes(65536, '\0');
    const ssize_t count = ::recv(socket_.native_handle(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (ended != nullptr && (count == 0 || (count < 0 && errno != EAGAIN))) {
      *ended = true;
    }
    bytes.resize(count > 0 ? static_cast<std::size_t>(count) : 0);
    return bytes;
  }

 private:
  boost::asio::ip::tcp::socket socket_;
};

}  // namespace mbgate::io
