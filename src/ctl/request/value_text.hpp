// SPDX-License-Identifier: Apache-2.0
// Values as the operator writes and reads them: bits and numbers in decimal or hex, and texts.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "ctl/request/value.hpp"
#include "modbus/result.hpp"

namespace mbgate::ctl {

/// The bits of a value that is no text. Decimal with an optional '-', hex as the bit pattern
/// ("0xFFFE" is -2 as i16); f32 and f64 also with a fraction or an exponent; bits are 0, 1, off or
/// on. The error is a full sentence.
Result<std::uint64_t, std::string> parse_value(ValueType type, std::string_view text);

/// All values of a write. A text is one value, and becomes registers: a zero byte fills the last
/// one. The error is a full sentence.
Result<std::vector<std::uint64_t>, std::string> parse_values(ValueType type,
                                                             std::span<const std::string> words);

/// A protocol address, 0 to 65535, decimal or hex.
Result<std::uint16_t, std::string> parse_address(std::string_view text);

/// The plain value: "200000", "-5", "1.5". parse_value() reads it back, except what is no number
/// ("nan", "inf").
std::string value_text(ValueType type, std::uint64_t bits);

/// One line for people: "30: 200000 (0x00030D40)", "11: 1 (on)".
std::string value_line(std::uint16_t address, ValueType type, std::uint64_t bits);

/// The text in registers, up to the first zero byte. A byte that is not printable ASCII is shown as
/// "\x1B".
std::string text_of(std::span<const std::uint64_t> registers);

}  // namespace mbgate::ctl
