// SPDX-License-Identifier: Apache-2.0
// A device: one server on a bus, and the times that its maker or its user states for it.
#pragma once

#include <cstdint>
#include <string>

#include "modbus/rtu_timing.hpp"

namespace mbgate::drive {

using modbus::Duration;

/// The place of a bus in the settings.
enum class BusId : std::uint32_t {};

struct DeviceTiming {
  /// From the computed end of transmission to the first byte of the response (Serial Line
  /// V1.02, 2.4.1).
  Duration response_timeout = std::chrono::seconds(1);
  /// How long the device itself holds its answer back: Autonics' "response waiting time" (register
  /// 405204), MOONS' "transmit delay" (TD). Added to the timeout.
  Duration response_wait{0};
  /// Extra silence before each request to this device.
  Duration gap{0};
  /// How often a read is repeated after a timeout or a bad CRC.
  unsigned retries = 1;
  /// Repeats writes too. A relative move that is repeated moves the axis twice.
  bool retry_writes = false;
};

struct Device {
  std::string name;
  BusId bus{};
  std::uint8_t address = 1;  ///< 1 to 247
  DeviceTiming timing;
};

}  // namespace mbgate::drive
