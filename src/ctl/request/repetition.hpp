// SPDX-License-Identifier: Apache-2.0
// Times the start of each repetition, and ends the repetitions at SIGINT or SIGTERM. While an
// Interruption exists, these signals are held back until it waits, so that no output is cut off.
#pragma once

#include <array>
#include <chrono>
#include <csignal>
#include <fmt/chrono.h>
#include <memory>
#include <string>

namespace mbgate::ctl {

class Interruption {
 public:
  Interruption();
  ~Interruption();
  Interruption(const Interruption&) = delete;
  Interruption& operator=(const Interruption&) = delete;

  /// True as soon as a signal has come, false at `when`; an instant in the past only looks.
  [[nodiscard]] bool wait_until(std::chrono::steady_clock::time_point when) const;

  /// Does `work`, during which a signal ends the process at once, with status 0. Nothing that has
  /// been printed may still be in a buffer.
  template <typename Work>
  auto endable(Work work) const {
    sigprocmask(SIG_UNBLOCK, &signals_, nullptr);
    const std::unique_ptr<const sigset_t, HoldBack> open(&signals_);
    return work();
  }

 private:
  struct HoldBack {
    void operator()(const sigset_t* signals) const { sigprocmask(SIG_BLOCK, signals, nullptr); }
  };

  sigset_t signals_{};
  sigset_t held_before_{};
  std::array<struct sigaction, 4> before_{};  ///< in the order of the signals
};

/// The next start: a whole number of periods after `start`, that of the last one, and not before
/// `now`. Starts that were missed are not made up for.
std::chrono::steady_clock::time_point next_start(std::chrono::steady_clock::time_point start,
                                                 std::chrono::nanoseconds period,
                                                 std::chrono::steady_clock::time_point now);

/// "14:03:27.250", local time; as exact as `time`, which is in parts of a second.
template <typename Part>
std::string time_of_day(std::chrono::sys_time<Part> time) {
  const auto second = std::chrono::floor<std::chrono::seconds>(time);
  return fmt::format("{:%H:%M:%S}.{:0{}}", fmt::localtime(second.time_since_epoch().count()),
                     (time - second).count(), std::chrono::hh_mm_ss<Part>::fractional_width);
}
inline std::string time_of_day_now() {
  using namespace std::chrono;
  return time_of_day(floor<milliseconds>(system_clock::now()));
}

}  // namespace mbgate::ctl
