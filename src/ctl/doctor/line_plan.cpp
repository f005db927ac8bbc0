// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/line_plan.hpp"

#include <algorithm>
#include <fmt/core.h>

#include "base/text.hpp"
#include "modbus/request.hpp"

namespace mbgate::ctl {
namespace {

using bus::BusSettings;

std::string names_of(const std::vector<const BusSettings*>& buses) {
  return joined(buses, &BusSettings::name);
}

std::vector<const BusSettings*> buses_of(const gateway::Settings& settings, bool serial_only) {
  std::vector<const BusSettings*> buses;
  for (const auto id : settings.written_buses()) {
    if (const auto& bus = settings.bus(id); !serial_only || !bus.line.remote) {
      buses.push_back(&bus);
    }
  }
  return buses;
}

Result<const BusSettings*, std::string> find_bus(const std::string& name,
                                                 const gateway::Settings& settings) {
  const auto buses = buses_of(settings, name.empty());
  if (name.empty()) {
    if (buses.size() == 1) {
      return buses.front();
    }
    return buses.empty() ? "the configuration has no serial line: name a port with --device"
                         : "which bus? --bus with one of " + names_of(buses);
  }
  const auto found = std::ranges::find(buses, name, &BusSettings::name);
  if (found == buses.end()) {
    return fmt::format("the configuration has no bus {}; it has {}", name, names_of(buses));
  }
  return *found;
}

/// Why the bus cannot be examined.
std::optional<std::string> find_obstacle(const BusSettings& bus) {
  if (bus.line.remote) {
    return fmt::format("bus {} is a TCP connection to {}, not a serial port", bus.name,
                       bus.line.remote->host);
  }
  if (bus.line.framing != bus::Framing::rtu) {
    return fmt::format("bus {} has ASCII frames: only lines with RTU frames can be examined",
                       bus.name);
  }
  return std::nullopt;
}

PlannedUnit planned(std::uint8_t address, const std::string& name, const BusSettings& bus,
                    const drive::DeviceTiming& timing) {
  return {address, name, timing.response_timeout + timing.response_wait,
          timing.gap + bus.frame_gap.value_or(bus::Duration(0)), timing.response_wait};
}

std::vector<PlannedUnit> units_of(const DoctorCommand& command, const BusSettings& bus,
                                  const std::vector<drive::Device>& devices) {
  const auto read =
      modbus::make_read({modbus::Table::holding_registers, command.holding_register, 1});
  std::vector<PlannedUnit> units;
  for (const auto& device : devices) {
    const bool asked = command.units.empty() ||
                       std::ranges::find(command.units, device.address) != command.units.end();
    if (asked) {
      units.push_back(planned(device.address, device.name, bus, device.timing_of(read)));
    }
  }
  for (const auto address : command.units) {
    if (std::ranges::find(units, address, &PlannedUnit::address) == units.end()) {
      units.push_back(planned(address, {}, bus, bus.timing));
    }
  }
  return units;
}

}  // namespace

std::string unit_text(const PlannedUnit& unit) {
  const auto text = fmt::format("unit {}", unit.address);
  return unit.name.empty() ? text : fmt::format("{} ({})", text, unit.name);
}

LinePlan plan_of_port(const DoctorCommand& command) {
  LinePlan plan{command.port->device, command.port->mode};
  for (const auto address : command.units) {
    plan.units.push_back({.address = address, .timeout = command.port->timeout});
  }
  if (plan.units.empty()) {
    plan.nobody = fmt::format(
        "no unit is known: name one with --address, or find one with mbgatectl scan --device {}",
        plan.device);
  }
  return plan;
}

Result<LinePlan, std::string> plan_of_bus(const DoctorCommand& command,
                                          const gateway::Settings& settings) {
  const auto found = find_bus(command.bus, settings);
  if (!found) {
    // Said in full, because a text alone could be a plan too, its device.
    return {boost::system::in_place_error, found.error()};
  }
  const auto& bus = **found;
  if (auto obstacle = find_obstacle(bus)) {
    return {boost::system::in_place_error, *std::move(obstacle)};
  }
  const auto id = std::ranges::find(settings.buses, bus.name, &BusSettings::name);
  const drive::BusId number{static_cast<std::uint32_t>(id - settings.buses.begin())};
  LinePlan plan{bus.line.device, {bus.line.baud, bus.line.format}};
  plan.units = units_of(command, bus, settings.devices_on(number));
  plan.echo = bus.line.echo;
  plan.low_latency = bus.line.low_latency;
  if (bus.line.rs485 != bus::Rs485::off) {
    plan.nobody = "only mbgated changes the direction of this line (its key rs485)";
  } else if (plan.units.empty()) {
    plan.nobody = "the configuration has no device on this bus: name a unit with --address";
  }
  return plan;
}

}  // namespace mbgate::ctl
