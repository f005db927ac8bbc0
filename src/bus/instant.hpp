// SPDX-License-Identifier: Apache-2.0
// A point in time as the machine knows it: handed in from outside, never read from a clock.
#pragma once

#include <chrono>
#include <optional>

#include "modbus/rtu_timing.hpp"

namespace mbgate::bus {

using modbus::Duration;

/// The machine's time line. It has no now(): the shell maps a clock onto it, a simulation
/// counts it.
struct MachineTime {};

using Instant = std::chrono::time_point<MachineTime, Duration>;

/// The earlier of two deadlines, either of which may be absent.
inline std::optional<Instant> earlier(std::optional<Instant> a, std::optional<Instant> b) {
  if (!a || !b) {
    return a ? a : b;
  }
  return *a < *b ? a : b;
}

/// When the machine wants to be called next.
struct Wake {
  Instant at;
  /// True: a silence on the line is over then, and something may be transmitted. The caller may
  /// wake early and wait for the exact instant. False: something is decided then, for example that
  /// an answer is missing. The caller must not come early for that.
  bool ends_silence = false;
};

/// When something comes that is no silence.
inline std::optional<Wake> wake_at(std::optional<Instant> at) {
  return at ? std::optional(Wake{*at}) : std::nullopt;
}

/// Is the first one due before the second? Of two at the same instant the one that must not come
/// early is.
constexpr bool is_before(const Wake& one, const Wake& other) {
  return one.at < other.at || (one.at == other.at && !one.ends_silence && other.ends_silence);
}

/// The earlier of two, either of which may be absent.
inline std::optional<Wake> earlier(std::optional<Wake> a, std::optional<Wake> b) {
  if (!a || !b) {
    return a ? a : b;
  }
  return is_before(*b, *a) ? b : a;
}

}  // namespace mbgate::bus
