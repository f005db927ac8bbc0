// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/period.hpp"

#include <algorithm>
#include <cstdio>
#include <ctime>

namespace mbgate::ctl {

std::chrono::steady_clock::time_point next_start(std::chrono::steady_clock::time_point start,
                                                 std::chrono::nanoseconds period,
                                                 std::chrono::steady_clock::time_point now) {
  const auto begun = (now - start + period - std::chrono::nanoseconds(1)) / period;
  return start + std::max<std::chrono::nanoseconds::rep>(begun, 1) * period;
}

std::string time_of_day(std::chrono::system_clock::time_point time) {
  const auto second = std::chrono::floor<std::chrono::seconds>(time);
  const auto rest = std::chrono::floor<std::chrono::milliseconds>(time - second);
  const std::time_t count = std::chrono::system_clock::to_time_t(second);
  std::tm local{};
  localtime_r(&count, &local);
  char text[64];
  std::snprintf(text, sizeof text, "%02d:%02d:%02d.%03d", local.tm_hour, local.tm_min, local.tm_sec,
                static_cast<int>(rest.count()));
  return text;
}

}  // namespace mbgate::ctl
