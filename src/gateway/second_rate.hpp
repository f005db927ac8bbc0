// SPDX-License-Identifier: Apache-2.0
// How often something happens: so many times within a second; after a pause as many at once.
#pragma once

#include <algorithm>

#include "bus/instant.hpp"

namespace mbgate::gateway {

class SecondRate {
 public:
  /// When the next place is: not later than now if it is free. `per_second`: 1 at least.
  [[nodiscard]] bus::Instant next(unsigned per_second, bus::Instant now) const {
    return std::max(rested_at_, now) + kSecond / per_second - kSecond;
  }
  /// Takes that place, and returns when it is.
  bus::Instant take(unsigned per_second, bus::Instant now) {
    const bus::Instant place = next(per_second, now);
    take(place);
    return place;
  }
  void take(bus::Instant place) { rested_at_ = place + kSecond; }
  /// Has there been a pause of a second, or what counts as one?
  [[nodiscard]] bool is_rested(bus::Instant now) const { return rested_at_ <= now; }
  [[nodiscard]] bus::Instant rested_at() const { return rested_at_; }

 private:
  static constexpr bus::Duration kSecond = std::chrono::seconds(1);
  bus::Instant rested_at_ = bus::Instant::min();
};

}  // namespace mbgate::gateway
