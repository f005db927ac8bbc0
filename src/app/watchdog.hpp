// SPDX-License-Identifier: Apache-2.0
// Tells systemd again and again that the gateway is well, from the thread that runs it. A gateway
// that hangs says nothing, and neither does one that misses its deadlines: systemd then ends it and
// starts another one.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>

namespace mbgate::app {

class Watchdog {
 public:
  /// `is_well` is asked before each `feed`.
  Watchdog(boost::asio::io_context& context, std::function<bool()> is_well,
           std::function<void()> feed);
  Watchdog(const Watchdog&) = delete;
  Watchdog& operator=(const Watchdog&) = delete;
  ~Watchdog() = default;

  /// Feeds now, and then every half of `limit`, until the io_context ends.
  void start(std::chrono::microseconds limit);

 private:
  void look();

  boost::asio::steady_timer timer_;
  std::function<bool()> is_well_;
  std::function<void()> feed_;
  std::chrono::microseconds limit_{0};
};

}  // namespace mbgate::app
