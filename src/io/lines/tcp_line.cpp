// SPDX-License-Identifier: Apache-2.0
#include "io/lines/tcp_line.hpp"

#include <linux/sockios.h>
#include <sys/ioctl.h>
#include <sys/socket.h>

#include <algorithm>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <cerrno>
#include <chrono>
#include <fmt/core.h>
#include <system_error>
#include <tuple>
#include <utility>
#include <variant>

#include "io/advice.hpp"
#include "io/lines/line.hpp"
#include "io/supervise.hpp"

namespace mbgate::io {
namespace {

using namespace boost::asio::experimental::awaitable_operators;
using boost::asio::error::operation_aborted;
using boost::asio::ip::tcp;
using boost::system::error_code;

/// A kernel that does not take a frame holds hundreds of others that the far end does not read.
constexpr std::chrono::milliseconds kTakeLimit{1000};

bool has_far_end_closed(int error) { return error == ECONNRESET || error == EPIPE; }

std::string text_of(int error) { return std::generic_category().message(error); }

/// What ended first: an operation on the socket, or the timer that limits it.
using Ended = std::variant<std::tuple<error_code>, std::tuple<error_code>>;
constexpr std::size_t kLimitReached = 1;

/// By close(); or by the end of the line, of which nothing may be touched then.
bool was_aborted(const Ended& ended) {
  return std::visit([](const auto& result) { return std::get<0>(result) == operation_aborted; },
                    ended);
}

/// With nobody listening at a port that the kernel also gives to connections, it may happen to be
/// given to this very one, which then talks to itself and keeps the port from its owner.
bool is_connected_to_itself(const tcp::socket& socket) {
  error_code near_error;
  error_code far_error;
  const auto near = socket.local_endpoint(near_error);
  const auto far = socket.remote_endpoint(far_error);
  return !near_error && !far_error && near == far;
}

/// Why a connection was not made.
error_code failure_of(const Ended& connecting, const tcp::socket& socket) {
  if (connecting.index() == kLimitReached) {
    return boost::asio::error::timed_out;
  }
  const error_code error = std::get<0>(std::get<0>(connecting));
  return !error && is_connected_to_itself(socket) ? boost::asio::error::connection_refused : error;
}

}  // namespace

TcpLine::TcpLine(LineContext context, drive::BusId bus, const bus::LineSettings& line)
    : context_(context),
      bus_(bus),
      remote_(*line.remote),
      times_(line.connection),
      tls_(line.tls),
      name_(to_text(remote_)),
      socket_(context.io),
      timer_(context.io) {}

TcpLine::~TcpLine() { close_socket(); }

void TcpLine::start_connecting(HostAddresses addresses) {
  supervise(context_.io, connect(std::move(addresses), generation_), "line connect");
}

boost::asio::awaitable<void> TcpLine::connect(HostAddresses addresses, unsigned generation) {
  std::string failures;
  for (const auto& address : addresses) {
    const std::string end = fmt::format("{} {}", address.address().to_string(), address.port());
    if (const auto other = context_.ends->other(this, end)) {
      failures += (failures.empty() ? "" : "; ") + end + " is already open as bus " + *other;
      continue;
    }
    context_.ends->note(this, end, context_.events.name_of(bus_));
    timer_.expires_after(times_.connect_timeout);
    const auto ended =
        co_await (socket_.async_connect(address, kAsTuple) || timer_.async_wait(kAsTuple));
    if (was_aborted(ended) || generation != generation_) {
      co_return;
    }
    const error_code error = failure_of(ended, socket_);
    std::string failure = error ? error.message() + connect_advice(error.value()) : std::string();
    if (!error && tls_) {
      auto why_not = co_await secure(generation);
      if (!why_not) {
        co_return;
      }
      failure = *std::move(why_not);
    }
    if (failure.empty()) {
      finish_open();
      co_return;
    }
    close_socket();
    const bool by_name = addresses.size() > 1 || !numeric_endpoint(remote_);
    failures += fmt::format("{}{}{}", failures.empty() ? "" : "; ",
                            by_name ? address.address().to_string() + ": " : "", failure);
  }
  fail_to_open(failures);
}

void TcpLine::finish_open() {
  state_ = State::open;
  rest_.clear();
  const auto warnings =
      uplink_ ? std::exchange(warnings_, {}) : set_options(socket_.native_handle(), times_, name_);
  supervise(context_.io, read_loop(generation_), "line read");
  context_.events.line_opened(bus_, bus::LineKind::virtual_line, warnings);
}

void TcpLine::fail_to_open(const std::string& why) {
  state_ = State::closed;
  context_.events.line_lost(bus_, fmt::format("cannot connect to {}: {}", name_, why));
}

std::optional<std::string> TcpLine::transmit(modbus::Bytes frame) {
  if (state_ != State::open) {
    return std::nullopt;
  }
  if (!rest_.empty()) {
    close();
    return name_ + ": the far end has not accepted the previous frame";
  }
  const auto count = sys::send_now(socket_.native_handle(), frame);
  if (!count && has_far_end_closed(errno)) {
    return std::nullopt;  // the reader, whose turn is next, tells it
  }
  if (!count) {
    std::string why = fmt::format("{}: cannot send: {}", name_, text_of(errno));
    close();
    return why;
  }
  if (*count < frame.size()) {
    rest_.assign(frame.begin() + static_cast<std::ptrdiff_t>(*count), frame.end());
    supervise(context_.io, write_rest(generation_), "line write");
  }
  return std::nullopt;
}

// It waits, and reads by itself: an operation that had read already, and whose end waits its turn,
// would hold bytes back from read_now().
boost::asio::awaitable<void> TcpLine::read_loop(unsigned generation) {
  while (true) {
    const auto [error] = co_await socket_.async_wait(tcp::socket::wait_read, kAsTuple);
    if (error == operation_aborted || generation != generation_) {
      co_return;
    }
    if (error) {
      note_end(error);
      co_return;
    }
    read_now();
    if (generation != generation_) {
      co_return;
    }
  }
}

bool TcpLine::has_bytes() {
  error_code ignored;
  return state_ == State::open && socket_.available(ignored) > 0;
}

// The end of the stream counts: what is sent into a connection that the far end has closed is lost.
void TcpLine::read_now() {
  if (state_ != State::open) {
    return;
  }
  const auto error = read_waiting(
      buffer_,
      [fd = socket_.native_handle()](auto room) {
        return ::recv(fd, room.data(), room.size(), MSG_DONTWAIT);
      },
      [this] {
        error_code ignored;
        return socket_.available(ignored);
      },
      [this, generation = generation_](modbus::Bytes bytes) {
        context_.events.line_bytes(bus_, bytes);
        return generation == generation_;
      });
  if (error) {
    note_end(error);
  }
}

boost::asio::awaitable<void> TcpLine::write_rest(unsigned generation) {
  timer_.expires_after(kTakeLimit);
  while (!rest_.empty()) {
    const auto ended = co_await (socket_.async_wait(tcp::socket::wait_write, kAsTuple) ||
                                 timer_.async_wait(kAsTuple));
    if (was_aborted(ended) || generation != generation_) {
      co_return;
    }
    if (ended.index() == kLimitReached) {
      lose("the far end does not take a frame in time");
      co_return;
    }
    const auto count = sys::send_now(socket_.native_handle(), rest_);
    if (!count) {
      lose("cannot send: " + text_of(errno));
      co_return;
    }
    rest_.erase(rest_.begin(), rest_.begin() + static_cast<std::ptrdiff_t>(*count));
  }
}

void TcpLine::close() {
  state_ = State::closed;
  given_up_ = false;
  late_.reset();
  ++generation_;
  timer_.cancel();
  close_socket();
}

// Close alone would leave what the far end has not acknowledged to the kernel, which goes on
// sending it. A reset throws it away.
void TcpLine::close_socket() {
  context_.ends->forget(this);
  int unacknowledged = 0;
  error_code ignored;
  if (!rest_.empty() ||
      (::ioctl(socket_.native_handle(), SIOCOUTQ, &unacknowledged) == 0 && unacknowledged > 0)) {
    socket_.set_option(tcp::socket::linger(true, 0), ignored);
  }
  rest_.clear();
  socket_.close(ignored);
  uplink_.reset();
}

void TcpLine::note_end(const error_code& error) {
  if (std::string why = uplink_ ? uplink_->why() : std::string(); !why.empty()) {
    lose(why);
    return;
  }
  const bool eof = error == boost::asio::error::eof;
  if (!eof && !has_far_end_closed(error.value())) {
    lose(error.message());
    return;
  }
  close();
  context_.events.line_closed(
      bus_, fmt::format("{}: {}", name_,
                        eof ? "the far end has closed the connection" : error.message()));
}

void TcpLine::lose(const std::string& why) {
  close();
  context_.events.line_lost(bus_, fmt::format("{}: {}", name_, why));
}

}  // namespace mbgate::io
