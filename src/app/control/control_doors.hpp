// SPDX-License-Identifier: Apache-2.0
// Where clients of the HTTP interface come in: the Unix socket, and TCP addresses for those whom
// [http] allow names. The ones are counted apart from the others, so that a network keeps nobody
// from the Unix socket. Used on the thread of the interface alone, but for its construction.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <string>

#include "app/control/connection.hpp"
#include "routing/client_address.hpp"
#include "routing/route.hpp"

namespace mbgate::app {

class ControlDoors {
 public:
  /// `count` is to be held (Counted) as long as it is a connection.
  struct Entered {
    ControlStream stream;
    bool over_tcp = false;
    std::shared_ptr<std::size_t> count;
  };
  using Enter = std::function<void(Entered)>;
  /// Told of an address that may not connect, once.
  using Refused = std::function<void(const std::string& address)>;
  using UnixAcceptor = std::shared_ptr<boost::asio::local::stream_protocol::acceptor>;
  using TcpAcceptor = std::shared_ptr<boost::asio::ip::tcp::acceptor>;

  ControlDoors(const std::shared_ptr<boost::asio::io_context>& home, Enter enter, Refused refused)
      : home_(home), enter_(std::move(enter)), refused_(std::move(refused)) {}

  void open(UnixAcceptor acceptor);
  /// One of several of that number.
  void open(routing::ListenerId id, TcpAcceptor acceptor);
  /// Those of that number; who has entered stays.
  void close(routing::ListenerId id);
  void allow(routing::NetworkList networks);

 private:
  template <typename Acceptor>
  boost::asio::awaitable<void> accept(Acceptor acceptor);
  void let_in(boost::asio::local::stream_protocol::socket socket);
  void let_in(boost::asio::ip::tcp::socket socket);
  void enter(ControlStream stream, bool over_tcp, const std::shared_ptr<std::size_t>& count);
  void refuse(boost::asio::ip::tcp::socket socket, const routing::ClientAddress& address);

  std::shared_ptr<boost::asio::io_context> home_;
  Enter enter_;
  Refused refused_;
  routing::NetworkList allowed_;
  std::multimap<routing::ListenerId, TcpAcceptor> tcp_;
  std::shared_ptr<std::size_t> of_unix_ = std::make_shared<std::size_t>(0);
  std::shared_ptr<std::size_t> of_tcp_ = std::make_shared<std::size_t>(0);
  std::set<routing::ClientAddress> told_;  ///< addresses that refused_ was told of
};

}  // namespace mbgate::app
