// SPDX-License-Identifier: Apache-2.0
// The status line that `systemctl status` shows, and times and characters as JSON has them.
#pragma once

#include <boost/json/array.hpp>
#include <chrono>
#include <ranges>
#include <string>
#include <string_view>

#include "gateway/gateway.hpp"

namespace mbgate::app {

/// "2 listeners, 1 of 2 buses open, 3 clients"; "1 of 2 listeners, ..." while one waits for its
/// address.
std::string status_text(const gateway::Settings& settings, const gateway::Status& status,
                        std::size_t listeners_waiting);

/// "2026-11-24T22:10:00", in UTC, the second that has begun; what follows it, and the final Z, are
/// the caller's.
std::string utc_second(std::chrono::system_clock::time_point instant);
/// "2026-11-24T22:10:00.123Z"
std::string utc_millisecond(std::chrono::system_clock::time_point instant);
/// "2026-11-24T22:10:00.123456Z"
std::string utc_microsecond(std::chrono::system_clock::time_point instant);

/// Any bytes, such as a path of the file system, as UTF-8, which JSON requires: the text, with
/// U+FFFD in place of each byte that is no part of a valid character (RFC 3629).
std::string valid_utf8(std::string_view text);

/// What `to_json` makes of each item.
template <typename Items, typename ToJson>
boost::json::array array_of(const Items& items, ToJson to_json) {
  const auto all = std::views::transform(items, to_json);
  return boost::json::array(all.begin(), all.end());
}

}  // namespace mbgate::app
