// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <boost/container/small_vector.hpp>
#include <ranges>

#include "routing/access_rules.hpp"

namespace mbgate::routing {
namespace {

using drive::end_of;
using modbus::Table;
using modbus::TableRange;

// Every part of the set that this device has, under the tables by which its profile describes them.
boost::container::small_vector<RegisterSpan, 64> parts_of(const RegisterSet& set,
                                                          const TouchedRegisters& touched) {
  boost::container::small_vector<RegisterSpan, 64> parts(set.spans.begin(), set.spans.end());
  if (touched.device == nullptr) {
    return parts;
  }
  const drive::Profile& profile = touched.device->profile;
  const auto add = [&](const TableRange& range) {
    parts.push_back({range.table, range.first, static_cast<std::uint16_t>(end_of(range) - 1)});
  };
  for (const drive::Value& value : profile.values.all()) {
    if (set.values || (set.motion_commands && value.motion)) {
      add(value.range());
    }
  }
  if (set.motion_commands) {
    if (const auto& opcodes = profile.position_opcodes) {
      add({Table::holding_registers, opcodes->address, 1});
      add({Table::holding_registers, opcodes->position, 2});
    }
    for (const drive::WriteMatch& stop : profile.stops) {
      add({stop.table, stop.address, 1});
    }
  }
  if (set.communication_registers) {
    std::ranges::for_each(profile.communication, add);
    if (touched.reconfigures) {
      std::ranges::for_each(profile.guarded, add, &drive::GuardedWrite::range);
    }
  }
  for (RegisterSpan& part : parts) {
    part.table = profile.described_in(part.table);
  }
  return parts;
}

TableRange described(const TouchedRegisters& touched) {
  TableRange range = *touched.range;
  range.table =
      touched.device == nullptr ? range.table : touched.device->profile.described_in(range.table);
  return range;
}

}  // namespace

bool RegisterSet::covers(const TouchedRegisters& touched) const {
  const auto parts = parts_of(*this, touched);
  const TableRange range = described(touched);
  const auto is_named = [&](std::uint32_t address) {
    return std::ranges::any_of(parts, [&](const RegisterSpan& it) {
      return it.table == range.table && it.first <= address && address <= it.last;
    });
  };
  return std::ranges::all_of(std::views::iota(std::uint32_t{range.first}, end_of(range)), is_named);
}

bool RegisterSet::touches(const TouchedRegisters& touched) const {
  const TableRange range = described(touched);
  return std::ranges::any_of(parts_of(*this, touched), [&](const RegisterSpan& it) {
    return it.table == range.table && it.first < end_of(range) && range.first <= it.last;
  });
}

bool RegisterSet::contains(const RegisterSet& other) const {
  const auto in_one = [this](const RegisterSpan& span) {
    return std::ranges::any_of(spans, [&](const RegisterSpan& it) {
      return it.table == span.table && it.first <= span.first && span.last <= it.last;
    });
  };
  return std::ranges::all_of(other.spans, in_one) && (motion_commands || !other.motion_commands) &&
         (communication_registers || !other.communication_registers) && (values || !other.values) &&
         (stops || !other.stops);
}

}  // namespace mbgate::routing
