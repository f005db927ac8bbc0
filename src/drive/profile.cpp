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

}  // namespace mbgate::drive
