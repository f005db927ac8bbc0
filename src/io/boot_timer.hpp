// SPDX-License-Identifier: Apache-2.0
// A timer that counts the time while the computer is suspended, as the clock does, and expires at
// once when it wakes up. Asio's timers stand still meanwhile.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/posix/stream_descriptor.hpp>
#include <functional>

#include "bus/instant.hpp"

namespace mbgate::io {

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
