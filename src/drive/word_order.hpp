// SPDX-License-Identifier: Apache-2.0
// The order of the two registers of a 32-bit value. MOONS' drives have either (PR=5 big, PR=133
// little), the RS-485 stepper is little, the Autonics AiC big. Bytes within a register are always
// big-endian.
#pragma once

#include <array>
#include <cstdint>

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

}  // namespace mbgate::drive
