// SPDX-License-Identifier: Apache-2.0
// Instants as text for JSON.
#pragma once

#include <chrono>
#include <string>

namespace mbgate::app {

/// "2026-11-24T22:10:00", in UTC, the second that has begun; what follows it, and the final Z, are
/// the caller's.
std::string utc_second(std::chrono::system_clock::time_point instant);
/// "2026-11-24T22:10:00.123Z"
std::string utc_millisecond(std::chrono::system_clock::time_point instant);
/// "2026-11-24T22:10:00.123456Z"
std::string utc_microsecond(std::chrono::system_clock::time_point instant);

}  // namespace mbgate::app
