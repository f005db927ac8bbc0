// SPDX-License-Identifier: Apache-2.0
// The clock on the machine's time line. Every input of the machine is stamped with this clock and
// no other. It goes on while the computer is suspended: what a client asked before that is as old
// as it is for the client.
#pragma once

#include <chrono>
#include <ctime>

#include "bus/instant.hpp"

namespace mbgate::io {

inline bus::Instant now() {
  timespec at{};
  ::clock_gettime(CLOCK_BOOTTIME, &at);
  return bus::Instant(std::chrono::seconds(at.tv_sec) + std::chrono::nanoseconds(at.tv_nsec));
}

/// now(), or what a test has instead.
using Clock = bus::Instant (*)();

}  // namespace mbgate::io
