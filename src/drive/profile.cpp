// SPDX-License-Identifier: Apache-2.0
#include "drive/profile.hpp"

namespace mbgate::drive {

bool may_write(const modbus::Request& request, const GuardedWrite& guarded,
               std::optional<WordOrder> order) {
  constexpr unsigned kWordBits = 16;
  const TableRange& range = guarded.range;
  if (!request.writes() || !overlap(request.writes()->range, range)) {
    return false;
  }
  const auto first = request.written(range.first);
  if (range.count == 1 || !first) {
    return !first || guarded.fits(*first);
  }
  const auto second = request.written(static_cast<std::uint16_t>(range.first + 1));
  if (!second) {
    return true;
  }
  const std::uint32_t big = std::uint32_t{*first} << kWordBits | *second;
  const std::uint32_t little = std::uint32_t{*second} << kWordBits | *first;
  return (order != WordOrder::little && guarded.fits(big)) ||
         (order != WordOrder::big && guarded.fits(little));
}

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
      std::ranges::any_of(unanswered, hits, &UnansweredWrite::match) ||
      std::ranges::any_of(guarded,
                          [&](const GuardedWrite& write) {
                            return write.range.count == 1 && overlap(range, write.range);
                          }) ||
      (touches(communication, range) && !covers(communication, range))) {
    return true;
  }
  constexpr auto kHolding = modbus::Table::holding_registers;
  return position_opcodes && (contains(range, kHolding, position_opcodes->address) ||
                              overlap(range, {kHolding, position_opcodes->position, 2}));
}

bool writes(const modbus::Request& request, const WriteMatch& match) {
  const auto& field = request.writes();
  if (!field || !contains(field->range, match.table, match.address)) {
    return false;
  }
  const auto written = request.written(match.address);
  return written && match.fits(*written);
}

}  // namespace mbgate::drive
