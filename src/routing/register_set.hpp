// SPDX-License-Identifier: Apache-2.0
// Registers and coils that an access rule names: by their addresses in the device, or by what the
// device's profile says of them.
#pragma once

#include <cstdint>
#include <vector>

#include "drive/device.hpp"

namespace mbgate::routing {

/// Both ends belong to it.
struct RegisterSpan {
  modbus::Table table = modbus::Table::holding_registers;
  std::uint16_t first = 0;
  std::uint16_t last = 0xFFFF;
  friend bool operator==(const RegisterSpan&, const RegisterSpan&) = default;
};

struct RegisterSet {
  std::vector<RegisterSpan> spans{};
  /// Values whose write starts motion, opcodes with their position, and the registers of stops:
  /// what stops a drive with one value mostly starts it with another.
  bool motion_commands = false;
  /// With them, if the write reconfigures its device, the registers whose values decide that.
  bool communication_registers = false;
  bool values = false;  ///< all values of 32 and 64 bits
  /// No registers: writes of a stop. access_rules knows them by what they write.
  bool stops = false;

  [[nodiscard]] bool empty() const {
    return spans.empty() && !motion_commands && !communication_registers && !values && !stops;
  }
  /// Are all registers of the range in it? `device`: that they belong to; nullptr if nothing is
  /// known of it. Where a drive reads the same registers with 03 and 04, both tables are one.
  [[nodiscard]] bool covers(const drive::Device* device, const modbus::TableRange& range,
                            bool reconfigures = false) const;
  /// Is any of them in it?
  [[nodiscard]] bool touches(const drive::Device* device, const modbus::TableRange& range,
                             bool reconfigures = false) const;
  /// Is everything of the other one in it, whatever the device?
  [[nodiscard]] bool contains(const RegisterSet& other) const;
  friend bool operator==(const RegisterSet&, const RegisterSet&) = default;
};

}  // namespace mbgate::routing
