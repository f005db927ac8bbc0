// SPDX-License-Identifier: Apache-2.0
#include "app/watchdog.hpp"

#include <utility>

namespace mbgate::app {
namespace {

/// Part of the limit after which a gateway that was not well is looked at again. After a process
/// was stopped and continued, this may be called before the driver that catches up: that must not
/// cost half of the limit.
constexpr int kLooksAgain = 10;

}  // namespace

Watchdog::Watchdog(boost::asio::io_context& context, std::function<bool()> is_well,
                   std::function<void()> feed)
    : timer_(context), is_well_(std::move(is_well)), feed_(std::move(feed)) {}

void Watchdog::start(std::chrono::microseconds limit) {
  limit_ = limit;
  look();
}

void Watchdog::look() {
  const bool is_well = is_well_();
  if (is_well) {
    feed_();
  }
  timer_.expires_after(is_well ? limit_ / 2 : limit_ / kLooksAgain);
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (!error) {
      look();
    }
  });
}

}  // namespace mbgate::app
