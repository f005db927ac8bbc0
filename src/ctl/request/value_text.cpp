// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/value_text.hpp"

#include <bit>
#include <charconv>
#include <cmath>
#include <fmt/core.h>
#include <limits>
#include <type_traits>

namespace mbgate::ctl {
namespace {

/// How far the integers of a type go from zero: 32768 below and 32767 above.
struct Range {
  std::uint64_t below;
  std::uint64_t above;
};

template <typename Integer>
constexpr Range range_of() {
  constexpr std::uint64_t kAbove{std::numeric_limits<Integer>::max()};
  return {std::is_signed_v<Integer> ? kAbove + 1 : 0, kAbove};
}

constexpr Range range(ValueType type) {
  switch (type) {
    case ValueType::bit: return {0, 1};
    case ValueType::u16: return range_of<std::uint16_t>();
    case ValueType::i16: return range_of<std::int16_t>();
    case ValueType::u32: return range_of<std::uint32_t>();
    case ValueType::i32: return range_of<std::int32_t>();
    case ValueType::u64: return range_of<std::uint64_t>();
    case ValueType::i64: return range_of<std::int64_t>();
    case ValueType::f32:
    case ValueType::f64:
    case ValueType::text: break;  // have no range of integers
  }
  return {0, 0};
}

constexpr std::string_view type_word(ValueType type) {
  for (const auto& known : kTypeWords) {
    if (known.type == type) {
      return known.word;
    }
  }
  return {};
}

constexpr std::uint64_t bit_mask(ValueType type) {
  return std::numeric_limits<std::uint64_t>::max() >> (64 - 16 * width(type));
}

std::string quoted(std::string_view text) { return fmt::format("\"{}\"", text); }

/// The number that is the whole of a text. `error`: it is none, or its type cannot hold it.
template <typename Number>
struct WholeNumber {
  std::errc error{};
  Number number{};
};

template <typename Number, typename... Format>
WholeNumber<Number> whole_number(std::string_view text, Format... format) {
  WholeNumber<Number> whole;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, whole.number, format...);
  whole.error = at == end ? error : std::errc::invalid_argument;
  return whole;
}

bool is_hex(std::string_view text) { return text.starts_with("0x") || text.starts_with("0X"); }

Result<std::uint64_t, std::string> parse_bit(std::string_view text) {
  if (text == "1" || text == "on") {
    return 1U;
  }
  if (text == "0" || text == "off") {
    return 0U;
  }
  return quoted(text) + " is not a bit: 0, 1, off or on";
}

Result<std::uint64_t, std::string> parse_hex(ValueType type, std::string_view text) {
  const auto [error, bits] = whole_number<std::uint64_t>(text.substr(2), 16);
  if (error == std::errc::invalid_argument) {
    return quoted(text) + " is not a hexadecimal number";
  }
  if (error != std::errc{} || bits > bit_mask(type)) {
    return fmt::format("{} has more than {} bits", quoted(text), 16 * width(type));
  }
  return bits;
}

template <typename Float, typename Bits>
Result<std::uint64_t, std::string> parse_float(ValueType type, std::string_view text) {
  const auto [error, number] = whole_number<Float>(text, std::chars_format::general);
  if (error != std::errc{} || !std::isfinite(number)) {
    return fmt::format("{} is not a number that {} can hold", quoted(text), type_word(type));
  }
  return std::uint64_t{std::bit_cast<Bits>(number)};
}

Result<std::uint64_t, std::string> parse_integer(ValueType type, std::string_view text) {
  const bool negative = text.starts_with('-');
  const auto [error, magnitude] = whole_number<std::uint64_t>(text.substr(negative ? 1 : 0));
  if (error == std::errc::invalid_argument) {
    return quoted(text) + " is not a whole number";
  }
  const auto [below, above] = range(type);
  if (error != std::errc{} || magnitude > (negative ? below : above)) {
    return fmt::format("{} is outside {}, {}{} to {}", quoted(text), type_word(type),
                       below == 0 ? "" : "-", below, above);
  }
  return (negative ? 0 - magnitude : magnitude) & bit_mask(type);
}

Result<std::vector<std::uint64_t>, std::string> parse_text(std::span<const std::string> words) {
  if (words.size() != 1) {
    return "a string is one value: put a text with spaces in quotes";
  }
  const std::string& text = words.front();
  if (text.empty()) {
    return "an empty string takes no register: write a 0 as u16 to end a text";
  }
  std::vector<std::uint64_t> registers((text.size() + 1) / 2);
  for (std::size_t at = 0; at < text.size(); ++at) {
    const auto byte = static_cast<std::uint8_t>(text[at]);
    registers[at / 2] |= std::uint64_t{byte} << (at % 2 == 0 ? 8U : 0U);
  }
  return registers;
}

template <typename Float>
std::string float_text(Float number) {
  std::array<char, 32> text{};  // the longest shortest form of a double has 24 characters
  const auto [end, error] = std::to_chars(text.data(), text.data() + text.size(), number);
  return {text.data(), end};
}

std::string character_text(std::uint8_t byte) {
  constexpr std::uint8_t kFirstPrintable = 0x20;
  constexpr std::uint8_t kLastPrintable = 0x7E;
  if (byte >= kFirstPrintable && byte <= kLastPrintable) {
    return {static_cast<char>(byte)};
  }
  return fmt::format("\\x{:02X}", byte);
}

}  // namespace

Result<std::uint64_t, std::string> parse_value(ValueType type, std::string_view text) {
  if (type == ValueType::bit) {
    return parse_bit(text);
  }
  if (is_hex(text)) {
    return parse_hex(type, text);
  }
  if (type == ValueType::f32) {
    return parse_float<float, std::uint32_t>(type, text);
  }
  if (type == ValueType::f64) {
    return parse_float<double, std::uint64_t>(type, text);
  }
  return parse_integer(type, text);
}

Result<std::vector<std::uint64_t>, std::string> parse_values(ValueType type,
                                                             std::span<const std::string> words) {
  if (type == ValueType::text) {
    return parse_text(words);
  }
  std::vector<std::uint64_t> values;
  for (const auto& word : words) {
    const auto value = parse_value(type, word);
    if (!value) {
      return value.error();
    }
    values.push_back(*value);
  }
  return values;
}

Result<std::uint16_t, std::string> parse_address(std::string_view text) {
  const auto [error, address] = is_hex(text) ? whole_number<std::uint64_t>(text.substr(2), 16)
                                             : whole_number<std::uint64_t>(text);
  if (error != std::errc{} || address > 0xFFFFU) {
    return quoted(text) + " is not an address, 0 to 65535 or 0x0 to 0xFFFF";
  }
  return static_cast<std::uint16_t>(address);
}

std::string value_text(ValueType type, std::uint64_t bits) {
  switch (type) {
    case ValueType::bit:
    case ValueType::u16:
    case ValueType::u32:
    case ValueType::u64: return std::to_string(bits);
    case ValueType::i16: return std::to_string(static_cast<std::int16_t>(bits));
    case ValueType::i32: return std::to_string(static_cast<std::int32_t>(bits));
    case ValueType::i64: return std::to_string(static_cast<std::int64_t>(bits));
    case ValueType::f32: return float_text(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
    case ValueType::f64: return float_text(std::bit_cast<double>(bits));
    case ValueType::text: return text_of({&bits, 1});
  }
  return {};
}

std::string value_line(std::uint16_t address, ValueType type, std::uint64_t bits) {
  std::string line = fmt::format("{}: {}", address, value_text(type, bits));
  if (type == ValueType::bit) {
    return line + (bits != 0 ? " (on)" : " (off)");
  }
  return fmt::format("{} (0x{:0{}X})", line, bits, 4 * width(type));
}

std::string text_of(std::span<const std::uint64_t> registers) {
  std::string text;
  for (const auto bits : registers) {
    for (const unsigned shift : {8U, 0U}) {
      const auto byte = static_cast<std::uint8_t>(bits >> shift);
      if (byte == 0) {
        return text;
      }
      text += character_text(byte);
    }
  }
  return text;
}

namespace {

/// How far up in its value a register is, in bits; `at` counts the registers of the value.
std::size_t shift_of(std::size_t at, ValueType type, drive::WordOrder order) {
  return 16 * (order == drive::WordOrder::big ? width(type) - 1 - at : at);
}

}  // namespace

std::vector<std::uint16_t> to_registers(ValueType type, drive::WordOrder order,
                                        std::span<const std::uint64_t> values) {
  std::vector<std::uint16_t> registers;
  registers.reserve(values.size() * width(type));
  for (const std::uint64_t bits : values) {
    for (std::size_t at = 0; at < width(type); ++at) {
      registers.push_back(static_cast<std::uint16_t>(bits >> shift_of(at, type, order)));
    }
  }
  return registers;
}

std::vector<std::uint64_t> to_values(ValueType type, drive::WordOrder order,
                                     std::span<const std::uint16_t> registers) {
  std::vector<std::uint64_t> values;
  values.reserve(registers.size() / width(type));
  for (std::size_t first = 0; first + width(type) <= registers.size(); first += width(type)) {
    std::uint64_t bits = 0;
    for (std::size_t at = 0; at < width(type); ++at) {
      bits |= std::uint64_t{registers[first + at]} << shift_of(at, type, order);
    }
    values.push_back(bits);
  }
  return values;
}

}  // namespace mbgate::ctl
