// SPDX-License-Identifier: Apache-2.0
// The values of a drive: which registers make up one 32- or 64-bit quantity. They never overlap.
#pragma once

#include <cstdint>
#include <vector>

#include "drive/register_range.hpp"

namespace mbgate::drive {

struct Value {
  modbus::Table table = modbus::Table::holding_registers;
  std::uint16_t first = 0;
  std::uint8_t registers = 2;  ///< 2 or 4
  bool motion = false;         ///< writing it starts motion: it is written whole or not at all

  [[nodiscard]] TableRange range() const { return {table, first, registers}; }
  [[nodiscard]] std::uint32_t end() const { return end_of(range()); }
  friend bool operator==(const Value&, const Value&) = default;
};

class ValueSet {
 public:
  /// False, and nothing changed, if it overlaps a value that is there.
  bool add(const Value& value);
  /// The value that the register belongs to; nullptr if it belongs to none.
  [[nodiscard]] const Value* at(modbus::Table table, std::uint32_t address) const;
  /// The first value with a register at `address` or behind it; nullptr if there is none.
  [[nodiscard]] const Value* from(modbus::Table table, std::uint32_t address) const;
  [[nodiscard]] bool any_in(const TableRange& range) const;
  [[nodiscard]] const std::vector<Value>& all() const { return values_; }
  friend bool operator==(const ValueSet&, const ValueSet&) = default;

 private:
  std::vector<Value> values_;  // by table and address
};

}  // namespace mbgate::drive
