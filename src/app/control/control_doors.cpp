// SPDX-License-Identifier: Apache-2.0
#include "app/control/control_doors.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <unistd.h>

#include <boost/asio/buffer.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cerrno>
#include <chrono>
#include <filesystem>
#include <fmt/core.h>
#include <new>
#include <string_view>
#include <utility>

#include "gateway/settings.hpp"
#include "io/advice.hpp"
#include "io/clients/resources.hpp"
#include "io/clients/tcp_server.hpp"
#include "io/supervise.hpp"

namespace mbgate::app {
namespace {

namespace asio = boost::asio;
using asio::ip::tcp;
using UnixSocket = asio::local::stream_protocol::socket;
using routing::ClientAddress;
using routing::ListenerId;

/// When there are too few descriptors: not again and again without a pause.
constexpr std::chrono::seconds kAcceptPause{1};
/// Of the descriptors kept for lines and files, the Unix socket may have these: an operator asks
/// just when there are too few.
constexpr int kForOperators = 16;
/// Of the connections over one kind of socket, a client (an address, or a user) may have these.
constexpr std::size_t kMostOfOne = gateway::kHttpConnections / 4;
/// After this many refused addresses the list begins anew, and one may be reported again.
constexpr std::size_t kMostReported = 1000;

/// False for want of memory: the next one may find some.
template <typename Socket>
bool is_let_in(const std::function<void(Socket)>& let_in, Socket& socket) {
  try {
    let_in(std::move(socket));
  } catch (const std::bad_alloc&) {
    return false;
  }
  return true;
}

std::string forbidden() {
  constexpr std::string_view kBody =
      R"({"error":"this address may not read: it is not in [http] allow"})"
      "\n";
  return fmt::format(
      "HTTP/1.1 403 Forbidden\r\n"
      "Content-Type: application/json\r\n"
      "Cache-Control: no-store\r\n"
      "Connection: close\r\n"
      "Content-Length: {}\r\n"
      "\r\n"
      "{}",
      kBody.size(), kBody);
}

using boost::asio::local::stream_protocol;

constexpr mode_t kOwnerAndGroup = 0660;
constexpr int kBacklog = 64;

std::string sentence(const std::string& path, const std::string& why) {
  return fmt::format("control socket {}: {}; mbgatectl status, reload and events do not work", path,
                     why);
}

// Only a socket that nobody listens on any more refuses. Whatever else comes of it, somebody has
// it.
bool is_left_over(boost::asio::io_context& context, const stream_protocol::endpoint& endpoint) {
  stream_protocol::socket probe(context, endpoint.protocol());
  probe.native_non_blocking(true);
  const auto* const address = endpoint.data();
  return ::connect(probe.native_handle(), address, static_cast<socklen_t>(endpoint.size())) != 0 &&
         errno == ECONNREFUSED;
}

/// What the kernel says where a user is none of those that the service may see (PrivateUsers= of
/// its unit): kernel.overflowuid, which nobody changes.
constexpr uid_t kHiddenUser = 65534;

}  // namespace

ControlDoors::ControlDoors(const std::shared_ptr<asio::io_context>& home, Enter enter,
                           Refused refused)
    : home_(home),
      enter_(std::move(enter)),
      refused_(std::move(refused)),
      of_unix_(gateway::kHttpConnections, kMostOfOne),
      of_tcp_(gateway::kHttpConnections, kMostOfOne) {}

void ControlDoors::open(UnixAcceptor acceptor) {
  std::function<void(UnixSocket)> let_in = [this](UnixSocket socket) {
    Asker asker = asker_of_unix_socket(socket.native_handle());
    enter(ControlStream(std::move(socket)), false, std::move(asker));
  };
  io::supervise(*home_, accept(std::move(acceptor), std::move(let_in), kForOperators), "control");
}

void ControlDoors::open(routing::ListenerId id, TcpAcceptor acceptor) {
  tcp_.emplace(id, acceptor);
  std::function<void(tcp::socket)> let_in = [this, id](tcp::socket socket) {
    this->let_in(id, std::move(socket));
  };
  io::supervise(*home_, accept(std::move(acceptor), std::move(let_in), 0), "http");
}

void ControlDoors::close(routing::ListenerId id) {
  const auto [first, last] = tcp_.equal_range(id);
  for (auto at = first; at != last; ++at) {
    boost::system::error_code ignored;
    at->second->close(ignored);
  }
  tcp_.erase(first, last);
}

void ControlDoors::close_clients(routing::ListenerId id) {
  close_if([id](const Connection& connection) { return connection.door == id; });
}

void ControlDoors::allow(routing::NetworkList networks) {
  if (networks == allowed_) {
    return;
  }
  allowed_ = std::move(networks);
  reported_.clear();
  close_if(
      [this](const Connection& connection) { return !contains(allowed_, connection.address); });
}

// What a connection waits for ends then, and it with that.
void ControlDoors::close_if(const std::function<bool(const Connection&)>& unwanted) {
  for (const Connection& connection : connections_) {
    const auto stream = connection.stream.lock();
    if (stream && unwanted(connection)) {
      stream->close();
    }
  }
}

// `kept_back`: so many descriptors from end_ on it may have all the same.
template <typename Socket, typename Acceptor>
asio::awaitable<void> ControlDoors::accept(Acceptor acceptor, std::function<void(Socket)> let_in,
                                           int kept_back) {
  while (acceptor->is_open()) {
    auto [error, socket] = co_await acceptor->async_accept(io::kAsTuple);
    if (!acceptor->is_open()) {
      break;  // whoever came at the last moment, too
    }
    // Subtracted, because there may be no end.
    const bool is_too_many = !error && socket.native_handle() - kept_back >= end_;
    if (!error && !is_too_many && is_let_in(let_in, socket)) {
      continue;
    }
    if (error != asio::error::operation_aborted) {
      boost::system::error_code ignored;
      socket.close(ignored);
      asio::steady_timer pause(*home_, kAcceptPause);
      co_await pause.async_wait(io::kAsTuple);
    }
  }
}

void ControlDoors::let_in(ListenerId door, tcp::socket socket) {
  boost::system::error_code error;
  const tcp::endpoint peer = socket.remote_endpoint(error);
  if (error) {
    return;  // it has gone
  }
  const ClientAddress address = io::address_of(peer);
  if (contains(allowed_, address)) {
    std::erase_if(connections_,
                  [](const Connection& connection) { return connection.stream.expired(); });
    connections_.push_back(
        {door, address, enter(ControlStream(std::move(socket)), true, asker_of(address))});
  } else {
    refuse(std::move(socket), address);
  }
}

std::weak_ptr<ControlStream> ControlDoors::enter(ControlStream stream, bool over_tcp, Asker asker) {
  if (!io::is_memory_left()) {
    return {};
  }
  auto entered = std::make_shared<ControlStream>(std::move(stream));
  auto place = (over_tcp ? of_tcp_ : of_unix_).take(asker.client, [held = std::weak_ptr(entered)] {
    if (const auto displaced = held.lock()) {
      displaced->close();
    }
  });
  if (!place) {
    return {};
  }
  enter_({entered, over_tcp, std::move(asker), std::move(place)});
  return entered;
}

// Without a look at what it asks, so that it holds nothing here.
void ControlDoors::refuse(tcp::socket socket, const ClientAddress& address) {
  static const std::string kForbidden = forbidden();
  boost::system::error_code ignored;
  socket.send(asio::buffer(kForbidden), 0, ignored);  // a new connection has room for it
  socket.shutdown(tcp::socket::shutdown_send, ignored);
  if (reported_.size() >= kMostReported) {
    reported_.clear();
  }
  if (reported_.insert(address).second) {
    refused_(address.to_text());
  }
}

Result<stream_protocol::acceptor, std::string> open_control_socket(boost::asio::io_context& context,
                                                                   const std::string& path) {
  // As long as the kernel takes them, without the final zero.
  if (path.size() >= sizeof(sockaddr_un::sun_path)) {
    return sentence(path, fmt::format("the path is too long, expected fewer than {} characters",
                                      sizeof(sockaddr_un::sun_path)));
  }
  const stream_protocol::endpoint endpoint(path);
  std::error_code no_status;
  if (std::filesystem::is_socket(path, no_status)) {
    if (!is_left_over(context, endpoint)) {
      return sentence(path, "another process uses it; give each mbgated its own [http] socket");
    }
    ::unlink(path.c_str());
  }
  boost::system::error_code error;
  stream_protocol::acceptor acceptor(context);
  acceptor.open(endpoint.protocol(), error);
  if (!error) {
    acceptor.bind(endpoint, error);
  }
  if (!error && ::chmod(path.c_str(), kOwnerAndGroup) != 0) {
    error.assign(errno, boost::system::system_category());
  }
  if (!error) {
    acceptor.listen(kBacklog, error);
  }
  if (error) {
    const auto folder = std::filesystem::path(path).parent_path();
    return sentence(path, error.message() +
                              io::folder_advice(folder.empty() ? "." : folder.string(),
                                                error.value(), "choose a path below /run/mbgate"));
  }
  return acceptor;
}

Asker asker_of(const routing::ClientAddress& address) {
  return {address.counted_as().to_text(), address.to_text()};
}

// No name of the user: it could come from a server, and be waited for.
Asker asker_of_unix_socket(int descriptor) {
  ucred peer{};
  socklen_t size = sizeof peer;
  if (::getsockopt(descriptor, SOL_SOCKET, SO_PEERCRED, &peer, &size) != 0) {
    return {"unknown", "an unknown process"};
  }
  const std::string user = "uid " + std::to_string(peer.uid);
  return {user, user + (peer.uid == kHiddenUser ? " (neither root nor the service's own)" : "") +
                    ", pid " + std::to_string(peer.pid)};
}

}  // namespace mbgate::app
