// SPDX-License-Identifier: Apache-2.0
#include "app/text.hpp"

#include <cstddef>
#include <cstdio>
#include <ctime>

#include "base/utf8.hpp"
#include "gateway/settings/numbering.hpp"

namespace mbgate::app {
namespace {

std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

std::string listeners_text(const gateway::Settings& settings) {
  return counted(gateway::count_there(settings.listeners), "listener", "listeners");
}

}  // namespace

std::string status_text(const gateway::Settings& settings, const gateway::Status& status,
                        std::size_t listeners_waiting) {
  const std::size_t buses = gateway::count_there(settings.buses);
  if (buses == 0) {
    return "no [[bus]] is configured";
  }
  const std::string listening =
      listeners_waiting == 0
          ? ""
          : std::to_string(gateway::count_there(settings.listeners) - listeners_waiting) + " of ";
  return listening + listeners_text(settings) + ", " + std::to_string(status.buses_open) + " of " +
         counted(buses, "bus", "buses") + " open, " + counted(status.clients, "client", "clients");
}

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

std::string valid_utf8(std::string_view text) {
  std::string valid;
  while (!text.empty()) {
    const std::size_t size = first_character(text).size;
    valid += size == 0 ? "\xEF\xBF\xBD" : text.substr(0, size);
    text.remove_prefix(size == 0 ? 1 : size);
  }
  return valid;
}

}  // namespace mbgate::app
