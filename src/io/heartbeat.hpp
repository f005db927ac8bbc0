// SPDX-License-Identifier: Apache-2.0
// Notices that the io thread has not run: the process was stopped (SIGSTOP, a debugger, a frozen
// control group, a paused virtual machine), the computer was suspended, or it got no processor
// time. What has come meanwhile is old, and nothing else says so: the kernel does not tell when
// bytes came.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <optional>

#include "io/clock.hpp"

namespace mbgate::io {

class Heartbeat {
 public:
  /// It wakes the io thread so often.
  static constexpr std::chrono::milliseconds kBeat{250};
  /// Not to have run for longer than this counts. A write may be late by as much without it.
  static constexpr std::chrono::milliseconds kLongest{500};

  /// `on_beat` is to call missed().
  Heartbeat(boost::asio::io_context& context, std::function<void()> on_beat);

  /// Not while nobody could have sent anything: an idle process sleeps.
  void beat_while(bool wanted, bus::Instant at = now());
  /// For how long the io thread has not been here, if it is too long. To be called before what has
  /// come is handed to the machine.
  std::optional<std::chrono::milliseconds> missed(bus::Instant now);

 private:
  void beat();

  boost::asio::steady_timer timer_;
  std::function<void()> on_beat_;
  std::optional<bus::Instant> last_;  ///< nothing: it does not beat
};

}  // namespace mbgate::io
