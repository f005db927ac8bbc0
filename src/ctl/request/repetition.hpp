// SPDX-License-Identifier: Apache-2.0
// Times the start of each repetition, and ends the repetitions at SIGINT or SIGTERM. While an
// Interruption exists, these signals are held back until it waits, so that no output is cut off.
#pragma once

#include <array>
#include <chrono>
#include <csignal>
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
    const Opening opening(signals_);
    return work();
  }

 private:
  class Opening {
   public:
    explicit Opening(const sigset_t& signals);
    ~Opening();
    Opening(const Opening&) = delete;
    Opening& operator=(const Opening&) = delete;

   private:
    const sigset_t& signals_;
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

/// "14:03:27.250", local time.
std::string time_of_day(std::chrono::system_clock::time_point time);

}  // namespace mbgate::ctl
