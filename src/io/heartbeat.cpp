// SPDX-License-Identifier: Apache-2.0
#include "io/heartbeat.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::io {

Heartbeat::Heartbeat(boost::asio::io_context& context, std::function<void()> on_beat)
    : timer_(context), on_beat_(std::move(on_beat)) {}

void Heartbeat::beat_while(bool wanted, bus::Instant at) {
  if (wanted == last_.has_value()) {
    return;
  }
  if (wanted) {
    last_ = at;
    beat();
  } else {
    last_.reset();
    timer_.cancel();
  }
}

std::optional<std::chrono::milliseconds> Heartbeat::missed(bus::Instant now) {
  if (!last_) {
    return std::nullopt;
  }
  const bus::Duration gap = now - *last_;
  last_ = std::max(*last_, now);
  return gap > kLongest ? std::optional(std::chrono::ceil<std::chrono::milliseconds>(gap))
                        : std::nullopt;
}

void Heartbeat::beat() {
  timer_.expires_after(kBeat);
  timer_.async_wait([this](const boost::system::error_code& error) {
    if (error || !last_) {
      return;
    }
    on_beat_();
    if (last_) {
      beat();
    }
  });
}

}  // namespace mbgate::io
