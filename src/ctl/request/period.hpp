// SPDX-License-Identifier: Apache-2.0
// When what is repeated starts again, and the time of day that stands before what it prints.
#pragma once

#include <chrono>
#include <string>

namespace mbgate::ctl {

/// The next start: a whole number of periods after `start`, that of the last one, and not before
/// `now`. Starts that were missed are not made up for.
std::chrono::steady_clock::time_point next_start(std::chrono::steady_clock::time_point start,
                                                 std::chrono::nanoseconds period,
                                                 std::chrono::steady_clock::time_point now);

/// "14:03:27.250", local time.
std::string time_of_day(std::chrono::system_clock::time_point time);

}  // namespace mbgate::ctl
