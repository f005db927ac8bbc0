// SPDX-License-Identifier: Apache-2.0
// Values as the operator writes and reads them: bits, 16-bit and 32-bit numbers, in decimal or hex.
// A value is carried as its bits; its type says what they mean.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drive/word_order.hpp"
#include "modbus/result.hpp"

namespace mbgate::ctl {

enum class ValueType : std::uint8_t {
  bit,  ///< a coil or a discrete input
  u16,
  i16,
  u32,
  i32,
  f32  ///< IEEE 754, single precision
};

/// How many registers a value takes; a bit takes one address of its table.
constexpr std::size_t width(ValueType type) {
  return type == ValueType::u32 || type == ValueType::i32 || type == ValueType::f32 ? 2 : 1;
}

/// The bits of a value. Decimal with an optional '-', hex as the bit pattern ("0xFFFE" is -2 as
/// i16); f32 also with a fraction or an exponent; bits are 0, 1, off or on. The error is a full
/// sentence.
Result<std::uint32_t, std::string> parse_value(ValueType type, std::string_view text);

/// A protocol address, 0 to 65535, decimal or hex.
Result<std::uint16_t, std::string> parse_address(std::string_view text);

/// The plain value: "200000", "-5", "1.5". parse_value() reads it back.
std::string value_text(ValueType type, std::uint32_t bits);

/// One line for people: "30: 200000 (0x00030D40)", "11: 1 (on)".
std::string value_line(std::uint16_t address, ValueType type, std::uint32_t bits);

/// Values to registers, and back. `registers` must hold whole values.
std::vector<std::uint16_t> to_registers(ValueType type, drive::WordOrder order,
                                        std::span<const std::uint32_t> values);
std::vector<std::uint32_t> to_values(ValueType type, drive::WordOrder order,
                                     std::span<const std::uint16_t> registers);

}  // namespace mbgate::ctl
