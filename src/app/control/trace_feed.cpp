// SPDX-License-Identifier: Apache-2.0
#include "app/control/trace_feed.hpp"

#include <utility>

#include "io/clock.hpp"

namespace mbgate::app {
namespace {

/// An operator sees no delay, and a busy bus has some ten transactions meanwhile.
constexpr std::chrono::milliseconds kBringInterval{50};

}  // namespace

TraceFeed::TraceFeed(boost::asio::io_context& gateway, ControlTarget& target, HasRoom has_room,
                     Deliver deliver)
    : target_(target),
      has_room_(std::move(has_room)),
      deliver_(std::move(deliver)),
      timer_(gateway) {}

void TraceFeed::set_on(bool on) {
  if (std::exchange(on_, on) == on) {
    return;
  }
  target_.set_traced(on);
  if (on) {
    wait();
  } else {
    timer_.cancel();
  }
}

void TraceFeed::wait() {
  timer_.expires_after(kBringInterval);
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error && on_) {
      bring();
      wait();
    }
  });
}

void TraceFeed::bring() {
  if (!has_room_()) {
    return;
  }
  auto taken = target_.take_trace();
  if (!taken.records.empty() || taken.lost > 0) {
    const auto since_zero = std::chrono::duration_cast<std::chrono::system_clock::duration>(
        io::now().time_since_epoch());
    deliver_({std::move(taken), std::chrono::system_clock::now() - since_zero});
  }
}

}  // namespace mbgate::app
