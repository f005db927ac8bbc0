// SPDX-License-Identifier: Apache-2.0
#include "io/clients/tcp_server.hpp"

#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <boost/asio/post.hpp>
#include <cerrno>
#include <utility>

#include "io/clients/resources.hpp"
#include "io/clock.hpp"
#include "io/supervise.hpp"

namespace mbgate::io {
namespace {

using boost::asio::ip::tcp;
using boost::system::error_code;

/// Accepted in one go at least, how long a go may take beyond that, and how long then nobody is:
/// clients that connect without end must not take the time that lines need. In that time many more
/// can be refused than let in, so that those who may not connect do not fill the backlog.
constexpr int kBatch = 4;
constexpr std::chrono::microseconds kGo{250};
constexpr std::chrono::milliseconds kBreath{1};
/// Turned away in one go for want of descriptors.
constexpr int kMostShed = 64;
/// More than the kernel's longest backlog: only a flood of new connections could make the start
/// endless.
constexpr int kMostWaiting = 65536;
/// A failure that lasts must not keep the processor busy.
constexpr std::chrono::milliseconds kPause{100};

/// How long ago the client has connected, if nothing was sent to it yet. Linux counts from the last
/// sending, and the end of the handshake is the first.
std::chrono::milliseconds age_of(int socket) {
  tcp_info info{};
  socklen_t size = sizeof info;
  const bool known = ::getsockopt(socket, IPPROTO_TCP, TCP_INFO, &info, &size) == 0;
  return std::chrono::milliseconds(known ? info.tcpi_last_data_sent : 0);
}

sys::UniqueFd open_spare() { return sys::UniqueFd(::open("/dev/null", O_RDONLY | O_CLOEXEC)); }

int accept_socket(int listening, tcp::endpoint& peer) {
  auto size = static_cast<socklen_t>(peer.capacity());
  const int socket = ::accept4(listening, peer.data(), &size, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (socket >= 0) {
    peer.resize(size);
  }
  return socket;
}

}  // namespace

routing::ClientAddress address_of(const tcp::endpoint& peer) {
  const auto from = peer.address();
  const auto v6 = from.is_v6()
                      ? from.to_v6()
                      : boost::asio::ip::make_address_v6(boost::asio::ip::v4_mapped, from.to_v4());
  return routing::ClientAddress(v6.to_bytes());
}

TcpServer::TcpServer(boost::asio::io_context& context, gateway::ListenerId listener,
                     tcp::acceptor acceptor, AcceptEvents& events, int end)
    : context_(context),
      listener_(listener),
      acceptor_(std::move(acceptor)),
      pause_(context),
      events_(events),
      end_(end),
      spare_(open_spare()) {}

void TcpServer::accept_waiting() {
  for (int i = 0; i < kMostWaiting && accept_one(true) == Outcome::accepted; ++i) {
  }
}

void TcpServer::start() { supervise(context_, run(), "accept"); }

void TcpServer::stop() {
  error_code ignored;
  acceptor_.close(ignored);
  pause_.cancel();
}

boost::asio::awaitable<void> TcpServer::run() {
  while (true) {
    const auto [error] = co_await acceptor_.async_wait(tcp::acceptor::wait_read, kAsTuple);
    if (error || !acceptor_.is_open()) {
      co_return;
    }
    Outcome outcome = Outcome::accepted;
    const bus::Instant end = now() + kGo;
    for (int i = 0; outcome == Outcome::accepted && (i < kBatch || now() < end); ++i) {
      outcome = accept_one(false);
    }
    pause_.expires_after(outcome == Outcome::failed ? kPause : kBreath);
    const auto [stopped] = co_await pause_.async_wait(kAsTuple);
    if (stopped) {
      co_return;
    }
  }
}

TcpServer::Outcome TcpServer::accept_one(bool is_start) {
  tcp::endpoint peer;
  sys::UniqueFd socket(accept_socket(acceptor_.native_handle(), peer));
  const int failure = socket.is_open() ? 0 : errno;
  const int reason = failure != 0 ? failure : objection(socket.get());
  if (reason == 0) {
    return take(std::move(socket), peer, is_start);
  }
  socket.reset();
  switch (reason) {
    case EAGAIN: return Outcome::none_waiting;
    case EINTR:
    case ECONNABORTED: return Outcome::accepted;  // that one has gone; the next one may be there
    default: break;
  }
  const error_code error(reason, boost::system::system_category());
  if (reason == EMFILE || reason == ENFILE || reason == ENOMEM) {
    shed();
  }
  events_.accept_failed(listener_, error);
  return Outcome::failed;
}

int TcpServer::objection(int socket) const {
  if (socket >= end_) {
    return EMFILE;
  }
  return is_memory_left() ? 0 : ENOMEM;
}

TcpServer::Outcome TcpServer::take(sys::UniqueFd socket, const tcp::endpoint& peer, bool is_start) {
  const bus::Instant connected = is_start ? bus::Instant::min() : now() - age_of(socket.get());
  tcp::socket connection(context_);
  error_code error;
  connection.assign(peer.protocol(), socket.get(), error);
  if (error) {
    events_.accept_failed(listener_, error);
    return Outcome::failed;
  }
  socket.release();
  events_.client_accepted(listener_, {std::move(connection), peer, connected});
  return Outcome::accepted;
}

void TcpServer::shed() {
  spare_.reset();
  tcp::endpoint peer;
  for (int i = 0; i < kMostShed; ++i) {
    if (!sys::UniqueFd(accept_socket(acceptor_.native_handle(), peer)).is_open()) {
      break;
    }
  }
  spare_ = open_spare();
}

void ServerSet::add(gateway::ListenerId listener, boost::asio::ip::tcp::acceptor acceptor,
                    int end) {
  servers_.push_back(
      std::make_unique<TcpServer>(context_, listener, std::move(acceptor), events_, end));
  if (started_) {
    servers_.back()->start();
  }
}

void ServerSet::remove(gateway::ListenerId listener) {
  for (auto& server : servers_) {
    if (server->listener() == listener) {
      server->stop();
      // What waits for a client ends before this does.
      boost::asio::post(context_, [stopped = std::move(server)] {});
    }
  }
  std::erase(servers_, nullptr);
}

void ServerSet::set_end(int end) {
  for (const auto& server : servers_) {
    server->set_end(end);
  }
}

void ServerSet::start() {
  for (const auto& server : servers_) {
    server->accept_waiting();
  }
  for (const auto& server : servers_) {
    server->start();
  }
  started_ = true;
}

void ServerSet::stop() {
  for (const auto& server : servers_) {
    server->stop();
  }
}

}  // namespace mbgate::io
