// SPDX-License-Identifier: Apache-2.0
// What registers hold, and how values become registers. A value is carried as its bits; its type
// says what they mean. A text is carried as its registers, which are values of 16 bits.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "drive/word_order.hpp"

namespace mbgate::ctl {

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

/// What registers can hold, in the operator's words.
struct TypeWord {
  std::string_view word;
  ValueType type;
};
inline constexpr std::array kTypeWords = {
    TypeWord{"u16", ValueType::u16},    TypeWord{"i16", ValueType::i16},
    TypeWord{"u32", ValueType::u32},    TypeWord{"i32", ValueType::i32},
    TypeWord{"f32", ValueType::f32},    TypeWord{"u64", ValueType::u64},
    TypeWord{"i64", ValueType::i64},    TypeWord{"f64", ValueType::f64},
    TypeWord{"string", ValueType::text}};

/// How many registers a value takes; a bit takes one address of its table.
constexpr std::size_t width(ValueType type) {
  switch (type) {
    case ValueType::bit:
    case ValueType::u16:
    case ValueType::i16:
    case ValueType::text: return 1;
    case ValueType::u32:
    case ValueType::i32:
    case ValueType::f32: return 2;
    case ValueType::u64:
    case ValueType::i64:
    case ValueType::f64: return 4;
  }
  return 1;
}

/// Values to registers, and back. With the order little, the lowest 16 bits come first.
/// `registers` must hold whole values.
std::vector<std::uint16_t> to_registers(ValueType type, drive::WordOrder order,
                                        std::span<const std::uint64_t> values);
std::vector<std::uint64_t> to_values(ValueType type, drive::WordOrder order,
                                     std::span<const std::uint16_t> registers);

}  // namespace mbgate::ctl
