// SPDX-License-Identifier: Apache-2.0
#include "app/text.hpp"

#include <cstddef>
#include <fmt/chrono.h>

#include "base/text.hpp"
#include "base/utf8.hpp"
#include "gateway/settings.hpp"

namespace mbgate::app {

std::string status_text(const gateway::Settings& settings, const gateway::Status& status,
                        std::size_t listeners_waiting) {
  const std::size_t buses = gateway::count_there(settings.buses);
  if (buses == 0) {
    return "no [[bus]] is configured";
  }
  const std::string listening =
      listeners_waiting == 0
          ? ""
          : fmt::format("{} of ", gateway::count_there(settings.listeners) - listeners_waiting);
  return fmt::format("{}{}, {} of {} open, {}", listening,
                     counted(gateway::count_there(settings.listeners), "listener"),
                     status.buses_open, counted(buses, "bus", "buses"),
                     counted(status.clients, "client"));
}

std::string utc_second(std::chrono::system_clock::time_point instant) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}",
                     fmt::gmtime(std::chrono::floor<std::chrono::seconds>(instant)));
}

namespace {

/// With what follows the second, in so many `digits`.
template <typename Fraction>
std::string utc_text(std::chrono::system_clock::time_point instant, int digits) {
  using std::chrono::floor;
  const auto rest = floor<Fraction>(instant - floor<std::chrono::seconds>(instant));
  return fmt::format("{}.{:0{}}Z", utc_second(instant), rest.count(), digits);
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
