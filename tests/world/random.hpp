// SPDX-License-Identifier: Apache-2.0
// Chance that is the same everywhere: the engine is specified to the bit, the mapping is our own,
// because the distributions of the standard library are not portable.
#pragma once

#include <concepts>
#include <cstdint>
#include <random>
#include <span>
#include <type_traits>

#include "bus/instant.hpp"

namespace mbgate::world {

using namespace std::chrono_literals;
using bus::Duration;
using bus::Instant;

class Random {
 public:
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  /// From now on everybody's draws are these, two bytes each, as long as there are any: for
  /// fuzzers, which must be able to change one draw and leave the others.
  static void follow(std::span<const std::uint8_t> script) { script_ = script; }

  /// 0 .. limit - 1; 0 if the limit is 0. As many bits as the limit has: size_t is not the same
  /// everywhere.
  template <std::integral Number>
  std::make_unsigned_t<Number> below(Number limit) {
    if (limit == 0) {
      return 0;
    }
    return static_cast<std::make_unsigned_t<Number>>((draw() >> 8U) %
                                                     static_cast<std::uint64_t>(limit));
  }
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
  std::uint64_t draw() {
    if (script_.size() < 2) {
      return engine_();
    }
    const std::uint64_t drawn = script_[0] * 256ULL + script_[1];
    script_ = script_.subspan(2);
    return drawn << 8U;
  }

  inline static thread_local std::span<const std::uint8_t> script_{};
  std::mt19937_64 engine_;
};

}  // namespace mbgate::world
