// SPDX-License-Identifier: Apache-2.0
// A write with a special meaning for a drive: table, address, and which values.
#pragma once

#include <cstdint>

#include "modbus/request.hpp"

namespace mbgate::drive {

struct WriteMatch {
  modbus::Table table = modbus::Table::holding_registers;
  std::uint16_t address = 0;
  std::uint16_t mask = 0xFFFF;
  std::uint16_t value = 0;  ///< of the masked bits; of a coil 0000 or FF00
  bool other = false;       ///< any masked bits but `value`
  /// How many registers right behind it may be written together with it: the parameters of an
  /// opcode.
  std::uint16_t parameters = 0;

  [[nodiscard]] bool fits(std::uint16_t written) const {
    return ((written & mask) == value) != other;
  }
  friend bool operator==(const WriteMatch&, const WriteMatch&) = default;
};

/// Does the request (05, 06, 15, 16, 23) write this, alone or among others?
bool writes(const modbus::Request& request, const WriteMatch& match);

}  // namespace mbgate::drive
