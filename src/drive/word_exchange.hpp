// SPDX-License-Identifier: Apache-2.0
// Exchanges the word order of the values in a range of registers. Applied twice it changes nothing.
// Registers that belong to no value stay as they are, and so do the bytes within each register.
#pragma once

#include <boost/container/small_vector.hpp>
#include <cstdint>
#include <span>

#include "drive/value_set.hpp"

namespace mbgate::drive {

class WordExchange {
 public:
  /// Exchanges nothing.
  WordExchange() = default;
  /// For the registers of `range`; a value that `range` cuts is left alone.
  WordExchange(const ValueSet& values, const TableRange& range);

  /// `registers` are those of the range, two bytes each.
  void apply(std::span<std::uint8_t> registers) const;
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
