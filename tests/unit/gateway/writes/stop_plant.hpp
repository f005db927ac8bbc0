// SPDX-License-Identifier: Apache-2.0
// A plant with stops: units 1 and 2 are drives that a write of 00E1 to 007C stops.
#pragma once

#include "support/machine_rig.hpp"

namespace mbgate::test {

inline drive::Device stoppable(std::string_view name, std::uint8_t address) {
  drive::Device device;
  device.name = name;
  device.address = address;
  device.timing.response_timeout = 100ms;
  device.timing.retries = 0;
  device.profile.stops = {{modbus::Table::holding_registers, 0x7C, 0xFFFF, 0xE1}};
  return device;
}

inline Settings stop_plant(std::size_t pipeline = 1) {
  Settings settings = one_bus();
  settings.listeners[0].pipeline = pipeline;
  settings.devices = {stoppable("axis-x", 1), stoppable("axis-y", 2)};
  return settings;
}

inline std::string stop_request(unsigned transaction, unsigned unit = 1) {
  char text[64];
  std::snprintf(text, sizeof text, "%04X 0000 0006 %02X 06 007C 00E1 ", transaction, unit);
  return text;
}

/// What went out on the bus, without CRC.
inline Lines take_requests(MachineRig& rig, std::uint32_t bus = 0) {
  Lines requests;
  for (const auto& frame : rig.take_transmitted(bus)) {
    requests.push_back(frame.substr(0, frame.size() - 6));
  }
  return requests;
}

/// Answers that repeat the requests of one register.
inline std::string written(unsigned transaction, unsigned unit = 1, bool stop = false) {
  char text[64];
  std::snprintf(text, sizeof text, "00 %02X 00 00 00 06 %02X 06 00 %s", transaction, unit,
                stop ? "7C 00 E1" : "00 00 01");
  return text;
}

inline std::string busy(unsigned transaction, unsigned unit = 1) {
  char text[64];
  std::snprintf(text, sizeof text, "00 %02X 00 00 00 03 %02X 86 06", transaction, unit);
  return text;
}

inline constexpr auto kOne = "00 01 00 00 00 05 01 03 02 00 01";
inline constexpr auto kRead1 = "01 03 00 00 00 01";
inline constexpr auto kWrite1 = "01 06 00 00 00 01";
inline constexpr auto kWrite2 = "02 06 00 00 00 01";
inline constexpr auto kStop1 = "01 06 00 7C 00 E1";
inline constexpr auto kStop2 = "02 06 00 7C 00 E1";

}  // namespace mbgate::test
