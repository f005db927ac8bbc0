// SPDX-License-Identifier: Apache-2.0
// A point in time as the machine knows it: handed in from outside, never read from a clock.
#pragma once

#include <chrono>
#include <optional>

#include "modbus/rtu_timing.hpp"

namespace mbgate::bus {

using modbus::Duration;

/// The machine's time line. It has no now(): the shell maps the steady clock onto it, a simulation
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

}  // namespace mbgate::bus
