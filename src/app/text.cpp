// SPDX-License-Identifier: Apache-2.0
#include "app/text.hpp"

#include <algorithm>

namespace mbgate::app {
namespace {

std::string counted(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

/// Those that a reload took away are none.
std::size_t count_there(const auto& all) {
  return static_cast<std::size_t>(
      std::ranges::count_if(all, [](const auto& it) { return !it.is_gone; }));
}

std::string listeners_text(const gateway::Settings& settings) {
  return counted(count_there(settings.listeners), "listener", "listeners");
}

}  // namespace

std::string check_summary(const gateway::Settings& settings) {
  return "configuration ok: " + listeners_text(settings) + ", " +
         counted(settings.buses.size(), "bus", "buses") + ", " +
         counted(settings.devices.size(), "device", "devices") + ", " +
         counted(settings.routes.size(), "route", "routes");
}

std::string status_text(const gateway::Settings& settings, const gateway::Status& status,
                        std::size_t listeners_waiting) {
  const std::string listening =
      listeners_waiting == 0
          ? ""
          : std::to_string(count_there(settings.listeners) - listeners_waiting) + " of ";
  return listening + listeners_text(settings) + ", " + std::to_string(status.buses_open) + " of " +
         counted(count_there(settings.buses), "bus", "buses") + " open, " +
         counted(status.clients, "client", "clients");
}

}  // namespace mbgate::app
