// SPDX-License-Identifier: Apache-2.0
// From a name to the addresses that are tried.
#include <sys/socket.h>

#include <boost/asio/experimental/awaitable_operators.hpp>
#include <boost/asio/post.hpp>
#include <utility>
#include <variant>

#include "io/lines/tcp_line.hpp"
#include "io/lines/tcp_options.hpp"
#include "io/supervise.hpp"

namespace mbgate::io {

void TcpLine::open() {
  if (state_ != State::closed) {
    return;
  }
  state_ = State::opening;
  given_up_ = false;
  ++generation_;
  if (const auto endpoint = numeric_endpoint(remote_)) {
    start_connecting({*endpoint});
  } else if (late_) {
    start_connecting(*std::exchange(late_, std::nullopt));
  } else {
    limit_resolving();
    if (!resolving_) {
      resolve_name();
    }
  }
}

// The call itself cannot be limited. Its thread goes on, and what it finds is for the next open().
void TcpLine::limit_resolving() {
  timer_.expires_after(times_.connect_timeout);
  timer_.async_wait([this, generation = generation_](const boost::system::error_code& error) {
    if (!error && generation == generation_ && state_ == State::opening && resolving_) {
      given_up_ = true;
      fail_to_open("no name server has answered in time");
    }
  });
}

void TcpLine::resolve_name() {
  resolving_ = context_.blocking.run(
      [remote = remote_] { return resolve(remote); },
      [this](Result<HostAddresses, std::string> result) { finish_resolving(std::move(result)); });
  if (!resolving_) {
    boost::asio::post(context_.io, [this, generation = generation_] {
      if (generation == generation_) {
        fail_to_open("no thread is available to look up the name");
      }
    });
  }
}

void TcpLine::finish_resolving(Result<HostAddresses, std::string> result) {
  resolving_ = false;
  if (state_ != State::opening) {  // given up, or closed in the meantime
    late_ = result && given_up_ ? std::optional(std::move(*result)) : std::nullopt;
    return;
  }
  if (result) {
    start_connecting(std::move(*result));
  } else {
    fail_to_open(result.error());
  }
}

namespace {

using namespace boost::asio::experimental::awaitable_operators;
using boost::asio::ip::tcp;
using boost::system::error_code;

}  // namespace

// Puts TLS between the connection and this line: an uplink gets the socket, and its pair takes the
// socket's place. Why that failed, or an empty text; nothing if the line was closed meanwhile.
boost::asio::awaitable<std::optional<std::string>> TcpLine::secure(unsigned generation) {
  warnings_ = set_options(socket_.native_handle(), times_, name_);
  error_code error;
  sys::UniqueFd server(socket_.release(error));
  uplink_ = TlsUplink::start(std::move(server), *tls_);
  if (!uplink_) {
    co_return "no thread is available for TLS";
  }
  sys::UniqueFd line_end = uplink_->take_line_end();
  socket_.assign(tcp::v4(), line_end.get(), error);
  if (error) {
    co_return error.message();
  }
  static_cast<void>(line_end.release());
  timer_.expires_after(times_.connect_timeout);
  const auto ended = co_await (socket_.async_wait(tcp::socket::wait_read, kAsTuple) ||
                               timer_.async_wait(kAsTuple));
  const error_code result = std::visit([](const auto& one) { return std::get<0>(one); }, ended);
  if (result == boost::asio::error::operation_aborted || generation != generation_) {
    co_return std::nullopt;
  }
  if (ended.index() == 1) {  // the timer
    co_return "no answer to the TLS handshake in time";
  }
  std::uint8_t sign = 0;
  const ssize_t count = ::recv(socket_.native_handle(), &sign, 1, MSG_DONTWAIT);
  if (count == 1 && sign == TlsUplink::kReady) {
    co_return std::string();
  }
  const std::string why = uplink_->why();
  co_return why.empty() ? "the TLS handshake was not completed" : why;
}

}  // namespace mbgate::io
