// SPDX-License-Identifier: Apache-2.0
// From a name to the addresses that are tried.
#include <boost/asio/post.hpp>
#include <utility>

#include "io/lines/tcp_line.hpp"

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
        fail_to_open("no thread to look the name up on");
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

}  // namespace mbgate::io
