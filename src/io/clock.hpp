// SPDX-License-Identifier: Apache-2.0
// The steady clock on the machine's time line. Every input of the machine is stamped with this
// clock and no other.
#pragma once

#include <chrono>

#include "bus/instant.hpp"

namespace mbgate::io {

inline bus::Instant now() {
  return bus::Instant(std::chrono::duration_cast<bus::Duration>(
      std::chrono::steady_clock::now().time_since_epoch()));
}

/// The same point in time, for a timer.
inline std::chrono::steady_clock::time_point to_steady(bus::Instant instant) {
  return std::chrono::steady_clock::time_point(
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(instant.time_since_epoch()));
}

}  // namespace mbgate::io
