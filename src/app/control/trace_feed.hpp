// SPDX-License-Identifier: Apache-2.0
// Brings the trace from the gateway's thread to that of the HTTP interface, several times a second,
// while somebody reads it. Used only on the gateway's thread.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>

#include "app/control/control_target.hpp"
#include "gateway/trace/trace_book.hpp"

namespace mbgate::app {

/// Records that go over together.
struct TraceBatch {
  gateway::TraceBook::Taken taken;
  std::chrono::system_clock::time_point epoch;  ///< the time of day at the machine's instant 0
};

class TraceFeed {
 public:
  /// Takes a batch over to the other thread.
  using Deliver = std::function<void(TraceBatch)>;
  /// Has the other thread taken what was delivered? Until then records stay where they are, and the
  /// oldest are lost in the end.
  using HasRoom = std::function<bool()>;

  TraceFeed(boost::asio::io_context& gateway, ControlTarget& target, HasRoom has_room,
            Deliver deliver);

  void set_on(bool on);

 private:
  void wait();
  void bring();

  ControlTarget& target_;
  HasRoom has_room_;
  Deliver deliver_;
  boost::asio::steady_timer timer_;
  bool on_ = false;
};

}  // namespace mbgate::app
