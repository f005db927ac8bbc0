// SPDX-License-Identifier: Apache-2.0
#include "drive/value_set.hpp"

#include <tuple>

namespace mbgate::drive {

bool ValueSet::add(const Value& value) {
  if (any_in(value.range())) {
    return false;
  }
  const auto before = [](const Value& a, const Value& b) {
    return std::tie(a.table, a.first) < std::tie(b.table, b.first);
  };
  values_.insert(std::ranges::upper_bound(values_, value, before), value);
  return true;
}

const Value* ValueSet::from(modbus::Table table, std::uint32_t address) const {
  const auto found = std::ranges::partition_point(values_, [&](const Value& value) {
    return value.table < table || (value.table == table && value.end() <= address);
  });
  return found == values_.end() || found->table != table ? nullptr : &*found;
}

const Value* ValueSet::at(modbus::Table table, std::uint32_t address) const {
  const Value* value = from(table, address);
  return value != nullptr && value->first <= address ? value : nullptr;
}

bool ValueSet::any_in(const TableRange& range) const {
  const Value* value = from(range.table, range.first);
  return value != nullptr && value->first < end_of(range);
}

}  // namespace mbgate::drive
