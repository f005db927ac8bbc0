// SPDX-License-Identifier: Apache-2.0
// A histogram of durations: for each bound, the number of durations up to it since the counters
// were cleared. Collectors of metrics take differences.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "bus/instant.hpp"

namespace mbgate::bus {

class Histogram {
 public:
  static constexpr std::size_t kMostBounds = 17;

  /// The bounds ascend, are at most kMostBounds, and outlive the histogram.
  constexpr explicit Histogram(std::span<const Duration> bounds) : bounds_(bounds) {}

  void note(Duration duration) {
    if (!is_within(last_, duration)) {
      last_ =
          static_cast<std::size_t>(std::ranges::lower_bound(bounds_, duration) - bounds_.begin());
    }
    ++counts_[last_];
    sum_ += duration;
  }
  /// What another one with the same bounds has counted counts here too.
  void add(const Histogram& other) {
    std::ranges::transform(counts_, other.counts_, counts_.begin(), std::plus());
    sum_ += other.sum_;
  }

  [[nodiscard]] std::span<const Duration> bounds() const { return bounds_; }
  /// One more than there are bounds: those up to each bound and beyond the one before, and then
  /// those beyond the last.
  [[nodiscard]] std::span<const std::uint64_t> counts() const {
    return std::span(counts_).first(bounds_.size() + 1);
  }
  [[nodiscard]] Duration sum() const { return sum_; }

 private:
  /// Is it counted in this place?
  [[nodiscard]] bool is_within(std::size_t place, Duration duration) const {
    return (place == 0 || bounds_[place - 1] < duration) &&
           (place == bounds_.size() || duration <= bounds_[place]);
  }

  std::span<const Duration> bounds_;
  std::array<std::uint64_t, kMostBounds + 1> counts_{};
  Duration sum_{0};
  std::size_t last_ = 0;  // where the last one was counted: the next one is much like it
};

}  // namespace mbgate::bus
