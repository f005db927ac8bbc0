// SPDX-License-Identifier: Apache-2.0
// The steady clock as the machine's time line. The only clock that the machine's inputs are stamped
// with.
#pragma once

#include <chrono>

#include "bus/instant.hpp"

namespace mbgate::io {

inline bus::Instant now() {
  return bus::Instant(std::chrono::duration_cast<bus::Duration>(
      std::chrono::steady_clock::now().time_since_epoch()));
}

/// The same point in time, as a timer wants it.
inline std::chrono::steady_clock::time_point to_steady(bus::Instant instant) {
  return std::chrono::steady_clock::time_point(
      std::chrono::duration_cast<std::chrono::steady_clock::duration>(instant.time_since_epoch()));
}

}  // namespace mbgate::io
