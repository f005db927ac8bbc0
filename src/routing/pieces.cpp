// SPDX-License-Identifier: Apache-2.0
#include "routing/pieces.hpp"

#include <algorithm>

namespace mbgate::routing {

Pieces cut(const modbus::TableRange& range, std::uint16_t limit, const drive::Profile& profile) {
  Pieces pieces;
  const std::uint32_t end = drive::end_of(range);
  for (std::uint32_t at = range.first; at < end;) {
    std::uint32_t stop = std::min({end, at + limit, profile.group_end(range.table, at)});
    const drive::Value* value = profile.values.at(range.table, stop);
    if (stop < end && value != nullptr && value->first < stop && value->first > at) {
      stop = value->first;
    }
    pieces.push_back(
        {range.table, static_cast<std::uint16_t>(at), static_cast<std::uint16_t>(stop - at)});
    at = stop;
  }
  return pieces;
}

}  // namespace mbgate::routing
