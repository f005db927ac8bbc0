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

namespace {

/// With what follows the second, in so many `digits`.
template <typename Fraction>
std::string utc_text(std::chrono::system_clock::time_point instant, int digits) {
  using std::chrono::floor;
  const auto rest = floor<Fraction>(instant - floor<std::chrono::seconds>(instant));
  char text[sizeof ".123456Z"];
  std::snprintf(text, sizeof text, ".%0*dZ", digits, static_cast<int>(rest.count()));
  return utc_second(instant) + text;
}

}  // namespace

std::string utc_millisecond(std::chrono::system_clock::time_point instant) {
  return utc_text<std::chrono::milliseconds>(instant, 3);
}

std::string utc_microsecond(std::chrono::system_clock::time_point instant) {
  return utc_text<std::chrono::microseconds>(instant, 6);
}

}  // namespace mbgate::app
