// SPDX-License-Identifier: Apache-2.0
// Durations as text: a decimal number and its unit, "1.75ms". Exact in both directions.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace mbgate::config {

/// "250us", "1.75ms", "2s", "10m", "1h". Nothing for a missing unit, a sign, a space, an exponent,
/// a value finer than a nanosecond, or one longer than 1000 hours.
std::optional<std::chrono::nanoseconds> parse_duration(std::string_view text);

/// In the largest unit that needs no fraction. If that would be nanoseconds, as a decimal fraction
/// of ms or us. `duration` is not negative.
std::string to_text(std::chrono::nanoseconds duration);

}  // namespace mbgate::config
