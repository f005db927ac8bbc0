// SPDX-License-Identifier: Apache-2.0
// The order of the two registers of a 32-bit value. MOONS' drives have either (PR=5 big, PR=133
// little), the RS-485 stepper is little, the Autonics AiC big. Bytes within a register are always
// big-endian.
#pragma once

#include <algorithm>
#include <array>
#include <boost/container/small_vector.hpp>
#include <cstdint>
#include <span>

#include "drive/value_set.hpp"

namespace mbgate::drive {

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
    const Value* value = values.from(range.table, range.first);
    while (value != nullptr && value->first < end_of(range)) {
      if (value->first >= range.first && value->end() <= end_of(range)) {
        places_.push_back(
            {static_cast<std::uint16_t>(value->first - range.first), value->registers});
      }
      value = values.from(range.table, value->end());
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
