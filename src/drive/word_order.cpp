// SPDX-License-Identifier: Apache-2.0
#include "drive/word_order.hpp"

#include <algorithm>

namespace mbgate::drive {

WordExchange::WordExchange(const ValueSet& values, const TableRange& range) {
  const Value* value = values.from(range.table, range.first);
  while (value != nullptr && value->first < end_of(range)) {
    if (value->first >= range.first && value->end() <= end_of(range)) {
      places_.push_back({static_cast<std::uint16_t>(value->first - range.first), value->registers});
    }
    value = values.from(range.table, value->end());
  }
}

void WordExchange::apply(std::span<std::uint8_t> registers) const {
  for (const Place& place : places_) {
    const auto bytes =
        registers.subspan(std::size_t{place.offset} * 2, std::size_t{place.registers} * 2);
    std::ranges::reverse(bytes);
    for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) {
      std::swap(bytes[at], bytes[at + 1]);
    }
  }
}

}  // namespace mbgate::drive
