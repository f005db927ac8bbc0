// SPDX-License-Identifier: Apache-2.0
#include "app/utc_text.hpp"

#include <cstdio>
#include <ctime>

namespace mbgate::app {

std::string utc_second(std::chrono::system_clock::time_point instant) {
  const std::time_t second =
      std::chrono::system_clock::to_time_t(std::chrono::floor<std::chrono::seconds>(instant));
  std::tm fields{};
  ::gmtime_r(&second, &fields);
  char text[sizeof "2026-11-24T22:10:00"];
  std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%S", &fields);
  return text;
}

std::string utc_microsecond(std::chrono::system_clock::time_point instant) {
  using std::chrono::floor;
  const auto rest =
      floor<std::chrono::microseconds>(instant - floor<std::chrono::seconds>(instant));
  char text[sizeof ".123456Z"];
  std::snprintf(text, sizeof text, ".%06dZ", static_cast<int>(rest.count()));
  return utc_second(instant) + text;
}

}  // namespace mbgate::app
