// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/repetition.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <ctime>

#include "sys/unique_fd.hpp"

namespace mbgate::ctl {
namespace {

// The last two would leave a terminal as ncurses has made it.
constexpr std::array kEnding{SIGINT, SIGTERM, SIGQUIT, SIGHUP};

// Also where SIGINT was ignored: a shell does that to what it starts in the background.
void end_well(int /*signal*/) { _exit(0); }

}  // namespace

Interruption::Interruption() {
  sigemptyset(&signals_);
  for (const int signal : kEnding) {
    sigaddset(&signals_, signal);
  }
  sigprocmask(SIG_BLOCK, &signals_, &held_before_);
  struct sigaction ending {};
  ending.sa_handler = &end_well;
  for (std::size_t at = 0; at < kEnding.size(); ++at) {
    sigaction(kEnding[at], &ending, &before_[at]);
  }
}

Interruption::~Interruption() {
  for (std::size_t at = 0; at < kEnding.size(); ++at) {
    sigaction(kEnding[at], &before_[at], nullptr);
  }
  sigprocmask(SIG_SETMASK, &held_before_, nullptr);
}

bool Interruption::wait_until(std::chrono::steady_clock::time_point when) const {
  using namespace std::chrono;
  while (true) {
    const auto time =
        sys::timespec_of(std::max<nanoseconds>(when - steady_clock::now(), nanoseconds(0)));
    if (sigtimedwait(&signals_, nullptr, &time) > 0) {
      return true;
    }
    if (errno != EINTR) {
      return false;  // EAGAIN: the time is over
    }
  }
}

std::chrono::steady_clock::time_point next_start(std::chrono::steady_clock::time_point start,
                                                 std::chrono::nanoseconds period,
                                                 std::chrono::steady_clock::time_point now) {
  const auto begun = (now - start + period - std::chrono::nanoseconds(1)) / period;
  return start + std::max<std::chrono::nanoseconds::rep>(begun, 1) * period;
}

}  // namespace mbgate::ctl
