// SPDX-License-Identifier: Apache-2.0
// Limits how often something may happen within a second; after a pause, all of it at once.
#pragma once

#include <algorithm>

#include "bus/instant.hpp"

namespace mbgate::gateway {

class SecondRate {
 public:
  /// Is a place free now? `per_second`: 0: any number.
  [[nodiscard]] bool has_room(unsigned per_second, bus::Instant now) const {
    return per_second == 0 || next(per_second, now) <= now;
  }
  /// Takes the next place.
  void take(unsigned per_second, bus::Instant now) {
    if (per_second > 0) {
      rested_at_ = next(per_second, now) + kSecond;
    }
  }
  /// Has there been a pause of a second, or what counts as one?
  [[nodiscard]] bool is_rested(bus::Instant now) const { return rested_at_ <= now; }

 private:
  [[nodiscard]] bus::Instant next(unsigned per_second, bus::Instant now) const {
    return std::max(rested_at_, now) + kSecond / per_second - kSecond;
  }

  static constexpr bus::Duration kSecond = std::chrono::seconds(1);
  bus::Instant rested_at_ = bus::Instant::min();
};

}  // namespace mbgate::gateway
