// SPDX-License-Identifier: Apache-2.0
// The clock of the harness, and waiting by it as exactly as a process can.
#pragma once

#include <sys/prctl.h>

#include <cerrno>
#include <chrono>
#include <ctime>

namespace mbgate::bench {

using Clock = std::chrono::steady_clock;  ///< CLOCK_MONOTONIC, in nanoseconds
using Moment = Clock::time_point;

inline timespec to_timespec(Clock::duration duration) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(duration);
  return {static_cast<time_t>(seconds.count()), static_cast<long>((duration - seconds).count())};
}

/// Lets this thread's timers ring when they are due, and not up to 50 us later.
inline void want_exact_timers() { ::prctl(PR_SET_TIMERSLACK, 1UL); }

/// Sleeps by an ordinary timer.
inline void sleep_until(Moment moment) {
  const timespec until = to_timespec(moment.time_since_epoch());
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

}  // namespace mbgate::bench
