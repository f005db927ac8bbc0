// SPDX-License-Identifier: Apache-2.0
#include "config/check_summary.hpp"

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "config/needs.hpp"
#include "config/sections/sections.hpp"
#include "config/toml/duration_text.hpp"
#include "gateway/limits.hpp"

namespace mbgate::config {
namespace {

std::string number_of(std::size_t count, const char* one, const char* many) {
  return std::to_string(count) + " " + (count == 1 ? one : many);
}

// What becomes of a request that no rule matches, or that the last one decides for all.
std::string rules_text(const gateway::Settings& settings) {
  const auto& rules = settings.rules;
  const routing::AccessRule& last = rules.back();
  const bool any_role = std::ranges::any_of(settings.listeners,
                                            [](const auto& listener) { return has_tls(listener); });
  const bool decides_all = hides(last, routing::AccessRule{.any_role = any_role});
  const std::string end = decides_all ? "the last one, " + last.title() + ", " +
                                            (last.permits ? "permits" : "denies") + " what is left"
                                      : std::string("what none of them matches is denied");
  return number_of(rules.size(), "rule", "rules") + ": " + end;
}

// What the units of a Modbus TCP server are, where one device stands for it.
std::string units_text(const gateway::Settings& settings) {
  std::string text;
  for (std::size_t at = 0; at < settings.buses.size(); ++at) {
    const auto devices = settings.devices_on(drive::BusId{static_cast<std::uint32_t>(at)});
    if (settings.buses[at].line.framing == bus::Framing::tcp && devices.size() == 1) {
      const drive::Device& device = devices.front();
      text += "\nbus " + settings.buses[at].name + ": " +
              (device.has_every_unit
                   ? "every unit is device " + device.name
                   : "device " + device.name + " is unit " + std::to_string(device.address) +
                         " alone; if all units are this device, say one_device = true");
    }
  }
  return text;
}

// How long writes may wait for their turn on each bus, and stops for the line.
std::string waits_text(const gateway::Settings& settings) {
  const auto rounded = [](bus::Duration duration) {
    return to_text(std::chrono::ceil<std::chrono::milliseconds>(duration));
  };
  std::string text;
  for (std::size_t at = 0; at < settings.buses.size(); ++at) {
    const bus::BusSettings& bus = settings.buses[at];
    const auto devices = settings.devices_on(drive::BusId{static_cast<std::uint32_t>(at)});
    const bus::Duration longest = bus::longest_transaction(bus, devices);
    text += "\nbus " + bus.name + ": writes have " + rounded(gateway::write_deadline(longest)) +
            " by default; a stop is sent " +
            (bus.line.framing == bus::Framing::tcp
                 ? "at once"
                 : "within " + rounded(bus::longest_stop_wait(bus, devices)));
  }
  return text;
}

}  // namespace

std::string check_summary(const gateway::Settings& settings) {
  std::string text =
      "configuration ok: " + number_of(settings.listeners.size(), "listener", "listeners") + ", " +
      number_of(settings.buses.size(), "bus", "buses") + ", " +
      number_of(settings.devices.size(), "device", "devices") + ", " +
      number_of(settings.routes.size(), "route", "routes");
  if (!settings.rules.empty()) {
    text.append("\n").append(rules_text(settings));
  }
  text += units_text(settings);
  text += waits_text(settings);
  for (const auto& need : needs(settings)) {
    text.append("\n").append(need);
  }
  return text;
}

}  // namespace mbgate::config
