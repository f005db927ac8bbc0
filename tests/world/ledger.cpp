// SPDX-License-Identifier: Apache-2.0
#include "world/ledger.hpp"

namespace mbgate::world {

bool is_read(Bytes pdu) {
  switch (pdu[0]) {
    case 0x01:
    case 0x02:
    case 0x03:
    case 0x04:
    case 0x07:
    case 0x0B:
    case 0x0C:
    case 0x11:
    case 0x14:
    case 0x18: return true;
    case 0x2B: return pdu.size() > 1 && pdu[1] == kIdentification;
    default: return false;
  }
}

std::vector<Cell> cells_of(Bytes pdu) {
  std::vector<Cell> cells;
  const auto fields = fields_of(pdu);
  if (fields && !fields->writes && !is_read(pdu) && pdu.size() >= 5) {
    const std::uint32_t word = std::uint32_t{word_at(pdu, 1)} << 16U | word_at(pdu, 3);
    cells.push_back({Table::holding_registers, kOpaque + pdu[0], word});
    return cells;
  }
  if (!fields || !fields->writes) {
    return cells;
  }
  const Range& range = *fields->writes;
  if (pdu[0] == 0x16) {
    const std::uint32_t masks = std::uint32_t{fields->words[0]} << 16U | fields->words[1];
    cells.push_back({range.table, kMasks + range.first, masks});
    return cells;
  }
  for (unsigned at = 0; at < range.count; ++at) {
    cells.push_back({range.table, range.first + at, fields->words[at]});
  }
  return cells;
}

bool is_stopping(const Cell& cell) {
  const bool by_register = cell.table == Table::holding_registers &&
                           ((cell.place == kStopRegister && cell.word >> 12U == 5U) ||
                            (cell.place == kOtherStop && cell.word >> 12U == 4U));
  return by_register || (cell.table == Table::coils && cell.place == kStopCoil && cell.word != 0);
}

}  // namespace mbgate::world
