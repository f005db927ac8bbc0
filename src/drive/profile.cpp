// SPDX-License-Identifier: Apache-2.0
#include "drive/profile.hpp"

namespace mbgate::drive {

std::uint32_t Profile::group_end(modbus::Table table, std::uint32_t address) const {
  std::uint32_t end = 0x10000;
  for (const TableRange& group : groups) {
    if (contains(group, table, address)) {
      return end_of(group);
    }
    if (group.table == table && group.first > address) {
      end = std::min<std::uint32_t>(end, group.first);
    }
  }
  return end;
}

bool Profile::is_special(const TableRange& range) const {
  const auto hits = [&](const WriteMatch& match) {
    return contains(range, match.table, match.address);
  };
  if (std::ranges::any_of(stops, hits) ||
      std::ranges::any_of(unanswered, hits, &UnansweredWrite::match)) {
    return true;
  }
  constexpr auto kHolding = modbus::Table::holding_registers;
  return position_opcodes && (contains(range, kHolding, position_opcodes->address) ||
                              overlap(range, {kHolding, position_opcodes->position, 2}));
}

}  // namespace mbgate::drive
