// SPDX-License-Identifier: Apache-2.0
#include "app/text.hpp"

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

}  // namespace mbgate::app
