// SPDX-License-Identifier: Apache-2.0
#include "io/lines/tcp_options.hpp"

#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <fmt/core.h>
#include <system_error>

namespace mbgate::io {
namespace {

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

}  // namespace mbgate::io
