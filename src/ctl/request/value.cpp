// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/value.hpp"

#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>
#include <optional>

namespace mbgate::ctl {
namespace {

struct Range {
  std::int64_t lowest;
  std::int64_t highest;
};

template <typename Integer>
constexpr Range range_of() {
  return {std::numeric_limits<Integer>::min(), std::numeric_limits<Integer>::max()};
}

constexpr Range range(ValueType type) {
  switch (type) {
    case ValueType::bit: return {0, 1};
    case ValueType::u16: return range_of<std::uint16_t>();
    case ValueType::i16: return range_of<std::int16_t>();
    case ValueType::u32: return range_of<std::uint32_t>();
    case ValueType::i32: return range_of<std::int32_t>();
    case ValueType::f32: return {0, 0};  // has no range of integers
  }
  return {0, 0};
}

constexpr std::string_view type_name(ValueType type) {
  switch (type) {
    case ValueType::bit: return "bit";
    case ValueType::u16: return "u16";
    case ValueType::i16: return "i16";
    case ValueType::u32: return "u32";
    case ValueType::i32: return "i32";
    case ValueType::f32: return "f32";
  }
  return {};
}

constexpr std::uint32_t bit_mask(ValueType type) {
  return width(type) == 2 ? 0xFFFFFFFFU : 0xFFFFU;
}

std::string quoted(std::string_view text) { return "\"" + std::string(text) + "\""; }

/// The number that is the whole of `text`; nothing for anything else.
template <typename Number, typename... Format>
std::optional<Number> whole_number(std::string_view text, Format... format) {
  Number number{};
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number, format...);
  return error == std::errc{} && at == end ? std::optional(number) : std::nullopt;
}

bool is_hex(std::string_view text) { return text.starts_with("0x") || text.starts_with("0X"); }

Result<std::uint32_t, std::string> parse_bit(std::string_view text) {
  if (text == "1" || text == "on") {
    return 1U;
  }
  if (text == "0" || text == "off") {
    return 0U;
  }
  return quoted(text) + " is not a bit: 0, 1, off or on";
}

Result<std::uint32_t, std::string> parse_hex(ValueType type, std::string_view text) {
  const auto bits = whole_number<std::uint64_t>(text.substr(2), 16);
  if (!bits) {
    return quoted(text) + " is not a hexadecimal number";
  }
  if (*bits > bit_mask(type)) {
    return quoted(text) + " has more than " + std::to_string(16 * width(type)) + " bits";
  }
  return static_cast<std::uint32_t>(*bits);
}

Result<std::uint32_t, std::string> parse_float(std::string_view text) {
  const auto number = whole_number<float>(text, std::chars_format::general);
  if (!number || !std::isfinite(*number)) {
    return quoted(text) + " is not a number that f32 can hold";
  }
  return std::bit_cast<std::uint32_t>(*number);
}

Result<std::uint32_t, std::string> parse_integer(ValueType type, std::string_view text) {
  const auto number = whole_number<std::int64_t>(text);
  if (!number) {
    return quoted(text) + " is not a whole number";
  }
  const auto [lowest, highest] = range(type);
  if (*number < lowest || *number > highest) {
    return quoted(text) + " is outside " + std::string(type_name(type)) + ", " +
           std::to_string(lowest) + " to " + std::to_string(highest);
  }
  return static_cast<std::uint32_t>(*number) & bit_mask(type);
}

std::string float_text(float number) {
  std::array<char, 32> text{};  // the longest shortest form of a float has 15 characters
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), end};
}

}  // namespace

Result<std::uint32_t, std::string> parse_value(ValueType type, std::string_view text) {
  if (type == ValueType::bit) {
    return parse_bit(text);
  }
  if (is_hex(text)) {
    return parse_hex(type, text);
  }
  return type == ValueType::f32 ? parse_float(text) : parse_integer(type, text);
}

Result<std::uint16_t, std::string> parse_address(std::string_view text) {
  const auto address = is_hex(text) ? whole_number<std::uint64_t>(text.substr(2), 16)
                                    : whole_number<std::uint64_t>(text);
  if (!address || *address > 0xFFFFU) {
    return quoted(text) + " is not an address, 0 to 65535 or 0x0 to 0xFFFF";
  }
  return static_cast<std::uint16_t>(*address);
}

std::string value_text(ValueType type, std::uint32_t bits) {
  switch (type) {
    case ValueType::bit:
    case ValueType::u16:
    case ValueType::u32: return std::to_string(bits);
    case ValueType::i16: return std::to_string(static_cast<std::int16_t>(bits));
    case ValueType::i32: return std::to_string(static_cast<std::int32_t>(bits));
    case ValueType::f32: return float_text(std::bit_cast<float>(bits));
  }
  return {};
}

std::string value_line(std::uint16_t address, ValueType type, std::uint32_t bits) {
  std::string line = std::to_string(address) + ": " + value_text(type, bits);
  if (type == ValueType::bit) {
    return line + (bits != 0 ? " (on)" : " (off)");
  }
  std::array<char, 16> hex{};
  std::snprintf(hex.data(), hex.size(), " (0x%0*X)", static_cast<int>(4 * width(type)), bits);
  return line + hex.data();
}

std::vector<std::uint16_t> to_registers(ValueType type, drive::WordOrder order,
                                        std::span<const std::uint32_t> values) {
  std::vector<std::uint16_t> registers;
  for (const std::uint32_t bits : values) {
    if (width(type) == 1) {
      registers.push_back(static_cast<std::uint16_t>(bits));
    } else {
      const auto pair = drive::to_registers(bits, order);
      registers.insert(registers.end(), pair.begin(), pair.end());
    }
  }
  return registers;
}

std::vector<std::uint32_t> to_values(ValueType type, drive::WordOrder order,
                                     std::span<const std::uint16_t> registers) {
  std::vector<std::uint32_t> values;
  for (std::size_t at = 0; at + width(type) <= registers.size(); at += width(type)) {
    values.push_back(width(type) == 1
                         ? registers[at]
                         : drive::from_registers({registers[at], registers[at + 1]}, order));
  }
  return values;
}

}  // namespace mbgate::ctl
