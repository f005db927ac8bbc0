// SPDX-License-Identifier: Apache-2.0
// Many measured durations, and what can be said of them.
#pragma once

#include <chrono>
#include <cstddef>
#include <vector>

namespace mbgate::bench {

using Nanoseconds = std::chrono::nanoseconds;

/// Percentiles of a kind of duration, and the most; 0 where nothing was measured.
struct Spread {
  Nanoseconds p50{0};
  Nanoseconds p90{0};
  Nanoseconds p99{0};
  Nanoseconds p999{0};
  Nanoseconds most{0};
};

class Samples {
 public:
  void add(Nanoseconds value) { values_.push_back(value); }
  /// Keeps the room: adding after it costs no memory until there are more than before.
  void clear() { values_.clear(); }
  void reserve(std::size_t count) { values_.reserve(count); }
  /// Nearest rank: the smallest value that is not exceeded by the given share of all.
  [[nodiscard]] Spread spread() const;

 private:
  std::vector<Nanoseconds> values_;
};

}  // namespace mbgate::bench
