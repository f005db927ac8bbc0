// SPDX-License-Identifier: Apache-2.0
// From a name to the addresses that are tried; the options and TLS of a connection.
#include <netdb.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <boost/asio/experimental/awaitable_operators.hpp>
#include <boost/asio/post.hpp>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <fmt/core.h>
#include <memory>
#include <system_error>
#include <utility>
#include <variant>

#include "base/text.hpp"
#include "io/lines/tcp_line.hpp"
#include "io/supervise.hpp"

namespace mbgate::io {
namespace {

using namespace boost::asio::experimental::awaitable_operators;
using boost::asio::ip::tcp;
using boost::system::error_code;

struct FreeAddresses {
  void operator()(addrinfo* first) const { ::freeaddrinfo(first); }
};

/// Of the time in which an idle connection is probed, a third is left for the answer: beside
/// TCP_USER_TIMEOUT one unanswered probe is enough for the kernel.
constexpr int kPartForAnswer = 3;
/// Hundreds of frames. The kernel's own limit is megabytes, which a far end that never reads would
/// fill before anybody noticed.
constexpr int kSendBuffer = 64 * 1024;

}  // namespace

std::vector<std::string> set_options(int socket, const bus::ConnectionTimes& times,
                                     const std::string& name) {
  struct Option {
    const char* name;
    int level;
    int number;
    int value;
  };
  const auto milliseconds = [](bus::Duration time) {
    return static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(time).count());
  };
  const auto probe = static_cast<int>(times.idle_probe.count());
  const int for_answer = std::max(probe / kPartForAnswer, 1);
  const std::array options{
      Option{"TCP_NODELAY", IPPROTO_TCP, TCP_NODELAY, 1},
      Option{"SO_SNDBUF", SOL_SOCKET, SO_SNDBUF, kSendBuffer},
      Option{"TCP_USER_TIMEOUT", IPPROTO_TCP, TCP_USER_TIMEOUT,
             milliseconds(times.acknowledge_timeout)},
      Option{"TCP_KEEPIDLE", IPPROTO_TCP, TCP_KEEPIDLE, probe - for_answer},
      Option{"TCP_KEEPINTVL", IPPROTO_TCP, TCP_KEEPINTVL, for_answer},
      Option{"SO_KEEPALIVE", SOL_SOCKET, SO_KEEPALIVE, 1},
  };
  std::vector<std::string> warnings;
  for (const auto& option : options) {
    if (::setsockopt(socket, option.level, option.number, &option.value, sizeof option.value) !=
        0) {
      warnings.push_back(fmt::format("{}: cannot set {}: {}", name, option.name,
                                     std::generic_category().message(errno)));
    }
  }
  return warnings;
}

std::string to_text(const bus::Endpoint& remote) {
  return "tcp://" + host_and_port(remote.host, remote.port);
}

std::optional<tcp::endpoint> numeric_endpoint(const bus::Endpoint& remote) {
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(remote.host, error);
  return error ? std::nullopt : std::optional(tcp::endpoint(address, remote.port));
}

Result<HostAddresses, std::string> resolve(const bus::Endpoint& remote) {
  addrinfo wanted{};
  wanted.ai_family = AF_UNSPEC;
  wanted.ai_socktype = SOCK_STREAM;
  addrinfo* first = nullptr;
  const int failure = ::getaddrinfo(remote.host.c_str(), nullptr, &wanted, &first);
  if (failure != 0) {
    return failure == EAI_SYSTEM ? std::generic_category().message(errno)
                                 : std::string(::gai_strerror(failure));
  }
  const std::unique_ptr<addrinfo, FreeAddresses> owner(first);
  HostAddresses addresses;
  for (const addrinfo* each = first; each != nullptr && addresses.size() < kMaxHostAddresses;
       each = each->ai_next) {
    tcp::endpoint endpoint;
    if (each->ai_addrlen <= endpoint.capacity()) {
      std::memcpy(endpoint.data(), each->ai_addr, each->ai_addrlen);
      endpoint.resize(each->ai_addrlen);
      endpoint.port(remote.port);
      if (std::ranges::find(addresses, endpoint) == addresses.end()) {
        addresses.push_back(endpoint);
      }
    }
  }
  return addresses;
}

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
