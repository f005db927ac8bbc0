// SPDX-License-Identifier: Apache-2.0
// The values of a drive: which registers make up one 32- or 64-bit quantity. They never overlap.
#pragma once

#include <algorithm>
#include <cstdint>
#include <tuple>
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
  bool add(const Value& value) {
    if (any_in(value.range())) {
      return false;
    }
    const auto before = [](const Value& a, const Value& b) {
      return std::tie(a.table, a.first) < std::tie(b.table, b.first);
    };
    values_.insert(std::ranges::upper_bound(values_, value, before), value);
    return true;
  }
  /// The value that the register belongs to; nullptr if it belongs to none.
  [[nodiscard]] const Value* at(modbus::Table table, std::uint32_t address) const {
    const Value* value = from(table, address);
    return value != nullptr && value->first <= address ? value : nullptr;
  }
  /// The first value with a register at `address` or behind it; nullptr if there is none.
  [[nodiscard]] const Value* from(modbus::Table table, std::uint32_t address) const {
    const auto found = std::ranges::partition_point(values_, [&](const Value& value) {
      return value.table < table || (value.table == table && value.end() <= address);
    });
    return found == values_.end() || found->table != table ? nullptr : &*found;
  }
  [[nodiscard]] bool any_in(const TableRange& range) const {
    const Value* value = from(range.table, range.first);
    return value != nullptr && value->first < end_of(range);
  }
  [[nodiscard]] const std::vector<Value>& all() const { return values_; }
  friend bool operator==(const ValueSet&, const ValueSet&) = default;

 private:
  std::vector<Value> values_;  // by table and address
};

}  // namespace mbgate::drive
