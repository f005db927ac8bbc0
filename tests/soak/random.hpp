// SPDX-License-Identifier: Apache-2.0
// Chance that is the same everywhere: the engine is specified to the bit, the mapping is our own,
// because the distributions of the standard library are not portable.
#pragma once

#include <cstdint>
#include <random>
#include <vector>

#include "bus/instant.hpp"

namespace mbgate::soak {

using bus::Duration;
using bus::Instant;

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}

  /// 0 .. limit - 1; 0 if the limit is 0.
  std::uint64_t below(std::uint64_t limit) { return limit == 0 ? 0 : (engine_() >> 8U) % limit; }
  /// low .. high, both included.
  template <typename Number>
  Number between(Number low, Number high) {
    return static_cast<Number>(
        static_cast<std::int64_t>(low) +
        static_cast<std::int64_t>(below(static_cast<std::uint64_t>(
            static_cast<std::int64_t>(high) - static_cast<std::int64_t>(low) + 1))));
  }
  bool chance(unsigned permille) { return below(1000) < permille; }
  Duration duration(Duration low, Duration high) {
    return low >= high ? low : Duration(between(low.count(), high.count()));
  }
  template <typename Thing>
  Thing one_of(std::initializer_list<Thing> things) {
    return *(things.begin() + below(things.size()));
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace mbgate::soak
