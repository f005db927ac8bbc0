// SPDX-License-Identifier: Apache-2.0
// Accepts clients of the HTTP interface: on the Unix socket, and over TCP those that [http] allow
// names. Each kind of socket has a limit of its own, so that clients over the network cannot keep
// anybody from the Unix socket. A reload closes the TCP connections that it no longer allows. Used
// only on the thread of the interface, except for its construction.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/local/stream_protocol.hpp>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "app/control/asker.hpp"
#include "app/control/http_places.hpp"
#include "app/control/stream_readers.hpp"
#include "modbus/result.hpp"
#include "routing/client_address.hpp"
#include "routing/route.hpp"

namespace mbgate::app {

class ControlDoors {
 public:
  /// Keep `place` as long as the connection exists, and tell it what the connection does.
  struct Entered {
    std::shared_ptr<ControlStream> stream;
    bool over_tcp = false;
    Asker asker;
    std::shared_ptr<HttpPlaces::Place> place;
  };
  using Enter = std::function<void(Entered)>;
  /// Called once for each address that may not connect.
  using Refused = std::function<void(const std::string& address)>;
  using UnixAcceptor = std::shared_ptr<boost::asio::local::stream_protocol::acceptor>;
  using TcpAcceptor = std::shared_ptr<boost::asio::ip::tcp::acceptor>;

  ControlDoors(const std::shared_ptr<boost::asio::io_context>& home, Enter enter, Refused refused);

  void open(UnixAcceptor acceptor);
  /// One of several of that number.
  void open(routing::ListenerId id, TcpAcceptor acceptor);
  /// Those of that number; who has entered there stays.
  void close(routing::ListenerId id);
  /// Closes the connections of that number.
  void close_clients(routing::ListenerId id);
  /// Closes the connections of all others.
  void allow(routing::NetworkList networks);
  /// The first descriptor that no client over TCP may have.
  void set_end(int end) { end_ = end; }

 private:
  /// A connection over TCP, as long as it is one.
  struct Connection {
    routing::ListenerId door;
    routing::ClientAddress address;
    std::weak_ptr<ControlStream> stream;
  };

  template <typename Socket, typename Acceptor>
  boost::asio::awaitable<void> accept(Acceptor acceptor, std::function<void(Socket)> let_in,
                                      int kept_back);
  void let_in(routing::ListenerId door, boost::asio::ip::tcp::socket socket);
  std::weak_ptr<ControlStream> enter(ControlStream stream, bool over_tcp, Asker asker);
  void close_if(const std::function<bool(const Connection&)>& unwanted);
  void refuse(boost::asio::ip::tcp::socket socket, const routing::ClientAddress& address);

  std::shared_ptr<boost::asio::io_context> home_;
  Enter enter_;
  Refused refused_;
  int end_ = std::numeric_limits<int>::max();
  routing::NetworkList allowed_;
  std::vector<Connection> connections_;
  std::multimap<routing::ListenerId, TcpAcceptor> tcp_;
  HttpPlaces of_unix_;
  HttpPlaces of_tcp_;
  std::set<routing::ClientAddress> reported_;  ///< addresses that refused_ was called for
};

/// Listens at `path`, for mbgatectl: a Unix socket, which its owner and group may use. What an
/// ended process has left there is replaced. The error says why not, in a sentence that names the
/// path.
Result<boost::asio::local::stream_protocol::acceptor, std::string> open_control_socket(
    boost::asio::io_context& context, const std::string& path);

}  // namespace mbgate::app
