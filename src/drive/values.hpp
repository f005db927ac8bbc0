// SPDX-License-Identifier: Apache-2.0
// Registers and values of a drive: ranges of registers, values of several registers, and the order
// of their words.
#pragma once

#include <algorithm>
#include <array>
#include <boost/container/small_vector.hpp>
#include <cstdint>
#include <span>
#include <tuple>
#include <vector>

#include "modbus/request.hpp"

namespace mbgate::drive {

// Lists of register ranges, as profiles name them: write-only ones, parameter groups, those that a
// broadcast may write.

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

// The values of a drive: which registers make up one 32- or 64-bit quantity. They never overlap.

struct Value {
  modbus::Table table = modbus::Table::holding_registers;
  std::uint16_t first = 0;
  std::uint8_t registers = 2;  ///< 2 or 4
  bool motion = false;         ///< writing it starts motion: it is written whole or not at all

  [[nodiscard]] TableRange range() const { return {table, first, registers}; }
  [[nodiscard]] std::uint32_t end() const { return end_of(range()); }
  friend bool operator==(const Value&, const Value&) = default;
};

class ValueSet {
 public:
  /// False, and nothing changed, if it overlaps a value that is there.
  bool add(const Value& value) {
    if (any_in(value.range())) {
      return false;
    }
    const auto before = [](const Value& a, const Value& b) {
      return std::tie(a.table, a.first) < std::tie(b.table, b.first);
    };
    values_.insert(std::ranges::upper_bound(values_, value, before), value);
    return true;
  }
  /// The value that the register belongs to; nullptr if it belongs to none.
  [[nodiscard]] const Value* at(modbus::Table table, std::uint32_t address) const {
    const Value* value = from(table, address);
    return value != nullptr && value->first <= address ? value : nullptr;
  }
  /// The first value with a register at `address` or behind it; nullptr if there is none.
  [[nodiscard]] const Value* from(modbus::Table table, std::uint32_t address) const {
    const auto found = std::ranges::partition_point(values_, [&](const Value& value) {
      return value.table < table || (value.table == table && value.end() <= address);
    });
    return found == values_.end() || found->table != table ? nullptr : &*found;
  }
  /// Those with a register in the range.
  [[nodiscard]] std::span<const Value> in(const TableRange& range) const {
    const Value* const first = from(range.table, range.first);
    const Value* const all_end = values_.data() + values_.size();
    const auto is_in = [&](const Value& it) { return overlap(it.range(), range); };
    return first == nullptr ? std::span<const Value>()
                            : std::span(first, std::find_if_not(first, all_end, is_in));
  }
  [[nodiscard]] bool any_in(const TableRange& range) const { return !in(range).empty(); }
  [[nodiscard]] const std::vector<Value>& all() const { return values_; }
  friend bool operator==(const ValueSet&, const ValueSet&) = default;

 private:
  std::vector<Value> values_;  // by table and address
};

// The order of the two registers of a 32-bit value. MOONS' drives have either (PR=5 big, PR=133
// little), the RS-485 stepper is little, the Autonics AiC big. Bytes within a register are always
// big-endian.

enum class WordOrder : std::uint8_t {
  big,    ///< high word at the lower address
  little  ///< low word at the lower address
};

using RegisterPair = std::array<std::uint16_t, 2>;

/// The two registers of `value`, lower address first.
constexpr RegisterPair to_registers(std::uint32_t value, WordOrder order) {
  const auto high = static_cast<std::uint16_t>(value >> 16U);
  const auto low = static_cast<std::uint16_t>(value & 0xFFFFU);
  return order == WordOrder::big ? RegisterPair{high, low} : RegisterPair{low, high};
}

/// The value of two registers, lower address first.
constexpr std::uint32_t from_registers(RegisterPair registers, WordOrder order) {
  const std::uint32_t first = registers[0];
  const std::uint32_t second = registers[1];
  return order == WordOrder::big ? (first << 16U) | second : (second << 16U) | first;
}

// Exchanges the word order of the values in a range of registers. Applied twice it changes nothing.
// Registers that belong to no value stay as they are, and so do the bytes within each register.

class WordExchange {
 public:
  /// Exchanges nothing.
  WordExchange() = default;
  /// For the registers of `range`; a value that `range` cuts is left alone.
  WordExchange(const ValueSet& values, const TableRange& range) {
    for (const Value& value : values.in(range)) {
      if (value.first >= range.first && value.end() <= end_of(range)) {
        places_.push_back({static_cast<std::uint16_t>(value.first - range.first), value.registers});
      }
    }
  }

  /// `registers` are those of the range, two bytes each.
  void apply(std::span<std::uint8_t> registers) const {
    for (const Place& place : places_) {
      const auto bytes =
          registers.subspan(std::size_t{place.offset} * 2, std::size_t{place.registers} * 2);
      std::ranges::reverse(bytes);
      for (std::size_t at = 0; at + 1 < bytes.size(); at += 2) {
        std::swap(bytes[at], bytes[at + 1]);
      }
    }
  }
  [[nodiscard]] bool is_empty() const { return places_.empty(); }

 private:
  struct Place {
    std::uint16_t offset;
    std::uint8_t registers;
  };
  boost::container::small_vector<Place, 4> places_;
};

/// A register of a value as it is addressed in the other word order: the other half of a 32-bit
/// value, the mirrored word of a 64-bit one.
constexpr std::uint16_t partner(const Value& value, std::uint16_t address) {
  return static_cast<std::uint16_t>(2U * value.first + value.registers - 1U - address);
}

}  // namespace mbgate::drive
