// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "routing/access_rules.hpp"

namespace mbgate::routing {
namespace {

using drive::Device;
using modbus::Table;
using modbus::TableRange;

// The two registers of a position.
constexpr std::uint16_t kPositionRegisters = 2;

Table table_in(const Device* device, Table table) {
  return device == nullptr ? table : device->profile.described_in(table);
}

template <typename Visit>
void visit_communication(const TouchedRegisters& touched, Visit visit) {
  std::ranges::for_each(touched.device->profile.communication, visit);
  if (touched.reconfigures) {
    std::ranges::for_each(touched.device->profile.guarded, visit, &drive::GuardedWrite::range);
  }
}

template <typename Visit>
void visit_motion(const drive::Profile& profile, Visit visit) {
  for (const drive::Value& value : profile.values.all()) {
    if (value.motion) {
      visit(value.range());
    }
  }
  if (const auto& opcodes = profile.position_opcodes) {
    visit(TableRange{Table::holding_registers, opcodes->address, 1});
    visit(TableRange{Table::holding_registers, opcodes->position, kPositionRegisters});
  }
  for (const drive::WriteMatch& stop : profile.stops) {
    visit(TableRange{stop.table, stop.address, 1});
  }
}

// Every part of the set that this device has, with the address behind its end.
template <typename Visit>
void visit_parts(const RegisterSet& set, const TouchedRegisters& touched, Visit visit) {
  for (const RegisterSpan& span : set.spans) {
    visit(span.table, span.first, span.last + 1U);
  }
  const auto visit_range = [&](const TableRange& range) {
    visit(range.table, range.first, drive::end_of(range));
  };
  if (touched.device != nullptr && set.motion_commands) {
    visit_motion(touched.device->profile, visit_range);
  }
  if (touched.device != nullptr && set.communication_registers) {
    visit_communication(touched, visit_range);
  }
  if (touched.device != nullptr && set.values) {
    std::ranges::for_each(touched.device->profile.values.all(), visit_range, &drive::Value::range);
  }
}

// How far the set goes on from `address`; no further than `address` if it is not in it.
std::uint32_t reach_from(const RegisterSet& set, const TouchedRegisters& touched, Table table,
                         std::uint32_t address) {
  std::uint32_t reach = address;
  visit_parts(set, touched, [&](Table of, std::uint32_t first, std::uint32_t end) {
    if (table_in(touched.device, of) == table && first <= address) {
      reach = std::max(reach, end);
    }
  });
  return reach;
}

}  // namespace

bool RegisterSet::covers(const TouchedRegisters& touched) const {
  const Table table = table_in(touched.device, touched.range->table);
  std::uint32_t address = touched.range->first;
  while (address < drive::end_of(*touched.range)) {
    const std::uint32_t reach = reach_from(*this, touched, table, address);
    if (reach == address) {
      return false;
    }
    address = reach;
  }
  return true;
}

bool RegisterSet::touches(const TouchedRegisters& touched) const {
  const TableRange& range = *touched.range;
  const Table table = table_in(touched.device, range.table);
  bool found = false;
  visit_parts(*this, touched, [&](Table of, std::uint32_t first, std::uint32_t end) {
    found = found || (table_in(touched.device, of) == table && first < drive::end_of(range) &&
                      range.first < end);
  });
  return found;
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
