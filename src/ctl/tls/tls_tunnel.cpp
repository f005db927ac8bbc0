// SPDX-License-Identifier: Apache-2.0
#include "ctl/tls/tls_tunnel.hpp"

#include <pthread.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <csignal>
#include <optional>
#include <system_error>

#include "sys/tls_pump.hpp"

namespace mbgate::ctl {
TlsTunnel::TlsTunnel(TlsConnection connection) : connection_(std::move(connection)) {
  std::array<int, 2> ends{};
  if (::socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    throw std::system_error(errno, std::generic_category(), "socketpair");
  }
  ours_ = sys::UniqueFd(ends[0]);
  theirs_ = sys::UniqueFd(ends[1]);
  thread_ = std::thread([this] { carry(); });
}

TlsTunnel::~TlsTunnel() {
  ::shutdown(ours_.get(), SHUT_RDWR);
  thread_.join();
}

std::string TlsTunnel::why_ended() const { return has_ended_ ? why_ended_ : std::string(); }

void TlsTunnel::carry() {
  sigset_t all;
  sigfillset(&all);  // signals are for the thread that waits for them
  pthread_sigmask(SIG_BLOCK, &all, nullptr);
  sys::TlsPump pump(*connection_.stream, connection_.socket.get(), ours_.get());
  const bool is_server_gone = pump.carry(std::nullopt) == sys::TlsPump::End::stream;
  if (is_server_gone) {
    why_ended_ = failure_text(*connection_.stream, pump.last_step());
  }
  has_ended_ = true;
  if (!is_server_gone) {
    connection_.stream->say_goodbye();
  }
  ::shutdown(ours_.get(), SHUT_RDWR);
}

}  // namespace mbgate::ctl
