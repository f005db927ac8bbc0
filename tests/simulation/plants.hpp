// SPDX-License-Identifier: Apache-2.0
// Simulated plants, and registers of their drives.
#pragma once

#include "simulation/asked.hpp"

namespace mbgate::test {

inline constexpr std::uint16_t kFirst =
    0x003C;  // MOONS' user registers 40061 to 40104: 44 registers, any value
inline constexpr std::uint16_t kRegisters = 44;

inline BusPlan bus_plan(std::initializer_list<std::uint8_t> units,
                        modbus::Baud baud = modbus::Baud{115200}) {
  BusPlan plan;
  plan.bus.line.baud = baud;
  plan.bus.line.format = {8, modbus::Parity::none, 1};
  plan.bus.listen_first = 0ms;
  plan.bus.timing.response_timeout = 100ms;
  for (const std::uint8_t unit : units) {
    sim::DeviceSettings device;
    device.name = "drive-" + std::to_string(unit);
    device.address = unit;
    plan.devices.push_back(device);
  }
  return plan;
}

/// Registers of a drive.
struct Registers {
  std::uint8_t unit;
  std::uint16_t first;
  std::uint16_t count;
};

}  // namespace mbgate::test
