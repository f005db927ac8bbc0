// SPDX-License-Identifier: Apache-2.0
// Lists of register ranges, as profiles name them: write-only ones, parameter groups, those that a
// broadcast may write.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "modbus/request.hpp"

namespace mbgate::drive {

using modbus::TableRange;
using RangeList = std::vector<TableRange>;

/// The first address behind the range, up to 65536.
constexpr std::uint32_t end_of(const TableRange& range) {
  return std::uint32_t{range.first} + range.count;
}

constexpr bool contains(const TableRange& range, modbus::Table table, std::uint32_t address) {
  return range.table == table && address >= range.first && address < end_of(range);
}

constexpr bool overlap(const TableRange& a, const TableRange& b) {
  return a.table == b.table && a.first < end_of(b) && b.first < end_of(a);
}

/// Does one of the ranges share an address with `range`?
inline bool touches(const RangeList& list, const TableRange& range) {
  return std::ranges::any_of(list, [&](const TableRange& it) { return overlap(it, range); });
}

/// Is every address of `range` in one of the ranges?
inline bool covers(const RangeList& list, const TableRange& range) {
  for (std::uint32_t address = range.first; address < end_of(range); ++address) {
    if (std::ranges::none_of(
            list, [&](const TableRange& it) { return contains(it, range.table, address); })) {
      return false;
    }
  }
  return true;
}

}  // namespace mbgate::drive
