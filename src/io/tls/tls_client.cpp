// SPDX-License-Identifier: Apache-2.0
#include "io/tls/tls_client.hpp"

#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/use_awaitable.hpp>
#include <cerrno>
#include <utility>

#include "io/supervise.hpp"

namespace mbgate::io {
namespace {

using namespace boost::asio::experimental::awaitable_operators;
using boost::asio::ip::tcp;
using boost::system::error_code;
using PairSocket = boost::asio::local::stream_protocol::socket;

constexpr std::size_t kCarriedAtOnce = 2048;
/// How long a client may take, once the machine has closed its connection, for the last answers and
/// for its own goodbye. If the socket were closed with unread bytes, the kernel would reset the
/// connection, and these answers could be lost.
constexpr std::chrono::seconds kLinger{1};

}  // namespace

TlsClient::TlsClient(TlsClientContext& shared, std::uint64_t key,
                     std::shared_ptr<TlsContext> context, tcp::socket socket)
    : shared_(shared),
      key_(key),
      context_(std::move(context)),
      socket_(std::move(socket)),
      stream_(context_->new_ssl(), socket_.native_handle()),
      pair_(shared.io),
      timer_(shared.io) {
  SSL_set_accept_state(&stream_.ssl());
}

sys::UniqueFd TlsClient::make_pair() {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0, ends.data()) != 0) {
    return {};
  }
  error_code error;
  pair_.assign(boost::asio::local::stream_protocol(), ends[0], error);
  sys::UniqueFd theirs(ends[1]);
  if (error) {
    ::close(ends[0]);
    return {};
  }
  return shared_.closings.watch(ends[0], key_, false) ? std::move(theirs) : sys::UniqueFd();
}

void TlsClient::linger() { end_at(boost::asio::steady_timer::clock_type::now() + kLinger); }

boost::asio::awaitable<void> TlsClient::carry() {
  co_await (carry_up() && carry_down());
  end();
}

boost::asio::awaitable<void> TlsClient::carry_up() {
  while (socket_.is_open()) {
    shared_.look_for_stall();
    if (!socket_.is_open()) {
      co_return;  // what came in the stall has ended it
    }
    const Step step = read_up();
    if (!hand_up()) {
      if (!co_await wait_for_room()) {
        co_return;
      }
      continue;
    }
    if (step == Step::broken || step == Step::flooded) {
      end();
    } else if (step == Step::closed) {
      error_code ignored;
      pair_.shutdown(PairSocket::shutdown_send, ignored);
      // A reset after it is to be noticed still.
      if (is_down_ended_ || !shared_.hangups.watch(socket_.native_handle(), key_, false)) {
        end();
      }
      co_return;
    } else if (step == Step::done) {
      co_await boost::asio::post(shared_.io, boost::asio::use_awaitable);  // others go on
    } else if (!co_await wait_for(step)) {
      co_return;
    }
  }
}

/// Reads once, if everything read before has been handed up.
TlsClient::Step TlsClient::read_up() {
  if (!up_.empty()) {
    return Step::done;
  }
  std::array<std::uint8_t, kCarriedAtOnce> bytes{};
  std::size_t count = 0;
  const Step step = note(stream_.read(bytes, count));
  if (step == Step::done) {
    up_.assign(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(count));
  }
  return step;
}

/// Has the machine all of it? What it does not want any more counts too.
bool TlsClient::hand_up() {
  while (!up_.empty()) {
    const auto count = sys::send_now(pair_.native_handle(), up_);
    if (count == std::size_t{0}) {
      return false;
    }
    up_.erase(up_.begin(), up_.begin() + static_cast<std::ptrdiff_t>(count.value_or(up_.size())));
  }
  up_.shrink_to_fit();
  return true;
}

// Meanwhile nothing is read: a reset would not be noticed, and what the client has asked for before
// would still be sent.
boost::asio::awaitable<bool> TlsClient::wait_for_room() {
  const bool watched = shared_.hangups.watch(socket_.native_handle(), key_, false);
  const auto [error] = co_await pair_.async_wait(PairSocket::wait_write, kAsTuple);
  if (watched && socket_.is_open()) {
    shared_.hangups.forget(socket_.native_handle());
  }
  co_return !error && socket_.is_open();
}

std::size_t TlsClient::drain() {
  std::size_t drained = 0;
  Step step = Step::done;
  while ((step == Step::done || step == Step::again) && socket_.is_open() && hand_up()) {
    step = read_up();
    drained += step == Step::done ? up_.size() : 0;
  }
  if (step == Step::broken || step == Step::flooded) {
    end();
  } else if (step == Step::closed) {
    error_code ignored;
    pair_.shutdown(PairSocket::shutdown_send, ignored);
  }
  return drained;
}

boost::asio::awaitable<void> TlsClient::carry_down() {
  std::array<std::uint8_t, kCarriedAtOnce> bytes{};
  while (socket_.is_open()) {
    const ssize_t count = ::recv(pair_.native_handle(), bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (count > 0) {
      const auto some = std::span<const std::uint8_t>(bytes).first(static_cast<std::size_t>(count));
      if (!co_await write_down(some)) {
        end();
      }
    } else if (count < 0 && (errno == EAGAIN || errno == EINTR)) {
      const auto [error] = co_await pair_.async_wait(PairSocket::wait_read, kAsTuple);
      if (error) {
        co_return;
      }
    } else {
      co_await say_goodbye();
      co_return;
    }
  }
}

/// False: the connection is broken.
boost::asio::awaitable<bool> TlsClient::write_down(std::span<const std::uint8_t> bytes) {
  while (!bytes.empty() && socket_.is_open()) {
    std::size_t count = 0;
    const Step step = note(stream_.write(bytes, count));
    if (step == Step::done) {
      bytes = bytes.subspan(count);
    } else if (sys::is_over(step) || !co_await wait_for(step)) {
      co_return false;
    }
  }
  co_return socket_.is_open();
}

// The machine may take its last answers for sent once the kernel has all of them, and a FIN.
boost::asio::awaitable<void> TlsClient::say_goodbye() {
  while (socket_.is_open()) {
    const Step step = note(stream_.say_goodbye());
    if (step != Step::write_more || !co_await wait_for(step)) {
      break;
    }
  }
  error_code ignored;
  is_down_ended_ = true;
  const bool has_client_ended = (SSL_get_shutdown(&stream_.ssl()) & SSL_RECEIVED_SHUTDOWN) != 0;
  socket_.shutdown(tcp::socket::shutdown_send, ignored);
  pair_.shutdown(PairSocket::shutdown_send, ignored);  // with the machine's FIN it lingers
  if (has_client_ended) {
    end();
  }
}

void TlsClient::end_at(boost::asio::steady_timer::time_point when, const char* why) {
  timer_.expires_at(when);
  timer_.async_wait([weak = weak_from_this(), why](const error_code& error) {
    if (const auto client = weak.lock(); client && !error) {
      client->end(why);
    }
  });
}

void TlsClient::end(const std::string& why) {
  complaint_ = complaint_.empty() ? why : complaint_;
  error_code ignored;
  timer_.cancel();
  if (socket_.is_open()) {
    shared_.hangups.forget(socket_.native_handle());
  }
  socket_.close(ignored);
  pair_.close(ignored);
}

routing::ClientRole TlsClient::role() const {
  const X509* const certificate = SSL_get0_peer_certificate(&stream_.ssl());
  return certificate == nullptr ? routing::ClientRole{routing::ClientRole::Kind::unreadable, {}}
                                : role_in(certificate);
}

std::optional<std::string> TlsClient::objection(const TlsContext& context) const {
  X509* const certificate = SSL_get0_peer_certificate(&stream_.ssl());
  return certificate == nullptr
             ? std::optional<std::string>("no certificate")
             : context.objection(certificate, SSL_get_peer_cert_chain(&stream_.ssl()));
}

}  // namespace mbgate::io
