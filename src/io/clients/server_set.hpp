// SPDX-License-Identifier: Apache-2.0
// The sockets that accept clients. One listener may have several.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <memory>
#include <vector>

#include "io/clients/tcp_server.hpp"

namespace mbgate::io {

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
