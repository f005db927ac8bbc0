// SPDX-License-Identifier: Apache-2.0
#include "config/check_summary.hpp"

#include <cstddef>

#include "config/needs.hpp"

namespace mbgate::config {
namespace {

std::string number_of(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

}  // namespace

std::string check_summary(const gateway::Settings& settings) {
  std::string text =
      "configuration ok: " + number_of(settings.listeners.size(), "listener", "listeners") + ", " +
      number_of(settings.buses.size(), "bus", "buses") + ", " +
      number_of(settings.devices.size(), "device", "devices") + ", " +
      number_of(settings.routes.size(), "route", "routes");
  for (const auto& need : needs(settings)) {
    text.append("\n").append(need);
  }
  return text;
}

}  // namespace mbgate::config
