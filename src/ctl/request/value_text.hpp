// SPDX-License-Identifier: Apache-2.0
// Values as the operator writes and reads them: bits and numbers in decimal or hex, and texts.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "drive/values.hpp"
#include "modbus/result.hpp"

namespace mbgate::ctl {

/// What registers hold, and how values become registers. A value is carried as its bits; its type
/// says what they mean. A text is carried as its registers, which are values of 16 bits.
enum class ValueType : std::uint8_t {
  bit,  ///< a coil or a discrete input
  u16,
  i16,
  u32,
  i32,
  f32,  ///< IEEE 754, single precision
  u64,
  i64,
  f64,  ///< IEEE 754, double precision
  text  ///< two characters a register, high byte first
};

/// What registers can hold, in the operator's words, and how many of them a value takes.
struct TypeWord {
  std::string_view word;
  ValueType type;
  std::size_t registers;
};
inline constexpr std::array kTypeWords = {
    TypeWord{"u16", ValueType::u16, 1},    TypeWord{"i16", ValueType::i16, 1},
    TypeWord{"u32", ValueType::u32, 2},    TypeWord{"i32", ValueType::i32, 2},
    TypeWord{"f32", ValueType::f32, 2},    TypeWord{"u64", ValueType::u64, 4},
    TypeWord{"i64", ValueType::i64, 4},    TypeWord{"f64", ValueType::f64, 4},
    TypeWord{"string", ValueType::text, 1}};

/// How many registers a value takes; a bit takes one address of its table.
constexpr std::size_t width(ValueType type) {
  const auto* known = std::ranges::find(kTypeWords, type, &TypeWord::type);
  return known == kTypeWords.end() ? 1 : known->registers;
}

/// Values to registers, and back. With the order little, the lowest 16 bits come first.
/// `registers` must hold whole values.
std::vector<std::uint16_t> to_registers(ValueType type, drive::WordOrder order,
                                        std::span<const std::uint64_t> values);
std::vector<std::uint64_t> to_values(ValueType type, drive::WordOrder order,
                                     std::span<const std::uint16_t> registers);

/// All values of a write, as their bits. Decimal with an optional '-', hex as the bit pattern
/// ("0xFFFE" is -2 as i16); f32 and f64 also with a fraction or an exponent; bits are 0, 1, off or
/// on. A text is one value, and becomes registers: a zero byte fills the last one. The error is a
/// full sentence.
Result<std::vector<std::uint64_t>, std::string> parse_values(ValueType type,
                                                             std::span<const std::string> words);

/// A protocol address, 0 to 65535, decimal or hex.
Result<std::uint16_t, std::string> parse_address(std::string_view text);

/// The plain value: "200000", "-5", "1.5". parse_values() reads it back, except what is no number
/// ("nan", "inf").
std::string value_text(ValueType type, std::uint64_t bits);

/// One line for people: "30: 200000 (0x00030D40)", "11: 1 (on)".
std::string value_line(std::uint16_t address, ValueType type, std::uint64_t bits);

/// The text in registers, up to the first zero byte. A byte that is not printable ASCII is shown as
/// "\x1B".
std::string text_of(std::span<const std::uint64_t> registers);

}  // namespace mbgate::ctl
