// SPDX-License-Identifier: Apache-2.0
// The clock on the machine's time line. Every input of the machine is stamped with this clock and
// no other. It goes on while the computer is suspended, so that a request from before the
// suspension has the same age as for its client.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <chrono>
#include <ctime>
#include <functional>

#include "bus/instant.hpp"

namespace mbgate::io {

inline bus::Instant now() {
  timespec at{};
  ::clock_gettime(CLOCK_BOOTTIME, &at);
  return bus::Instant(std::chrono::seconds(at.tv_sec) + std::chrono::nanoseconds(at.tv_nsec));
}

/// now(), or what a test has instead.
using Clock = bus::Instant (*)();

/// A timer that counts the time while the computer is suspended, as the clock does, and expires at
/// once when it wakes up. Asio's timers stand still meanwhile.
class BootTimer {
 public:
  BootTimer(boost::asio::io_context& context, std::function<void()> on_ring);

  /// Rings once, after so long; what it was set to before is forgotten. It may ring for that all
  /// the same, if that is over already.
  void set(bus::Duration after);

 private:
  void wait();

  boost::asio::posix::stream_descriptor timer_;
  std::function<void()> on_ring_;
  bool waits_ = false;
};

}  // namespace mbgate::io
