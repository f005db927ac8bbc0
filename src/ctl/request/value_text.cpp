// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/value_text.hpp"

#include <algorithm>
#include <bit>
#include <charconv>
#include <cmath>
#include <fmt/core.h>
#include <limits>
#include <system_error>
#include <utility>

namespace mbgate::ctl {
namespace {

/// How far the integers of a type go from zero: 32768 below and 32767 above.
struct Range {
  std::uint64_t below;
  std::uint64_t above;
};

constexpr std::uint64_t bit_mask(ValueType type) {
  return std::numeric_limits<std::uint64_t>::max() >> (64 - 16 * width(type));
}

constexpr bool is_signed(ValueType type) {
  return type == ValueType::i16 || type == ValueType::i32 || type == ValueType::i64;
}

constexpr Range range(ValueType type) {
  const std::uint64_t all = bit_mask(type);
  return is_signed(type) ? Range{all / 2 + 1, all / 2} : Range{0, all};
}

/// The number that the bits of a signed type are.
std::int64_t signed_number(ValueType type, std::uint64_t bits) {
  const std::size_t unused = 64 - 16 * width(type);
  return static_cast<std::int64_t>(bits << unused) >> unused;
}

std::string_view type_word(ValueType type) {
  return std::ranges::find(kTypeWords, type, &TypeWord::type)->word;
}

std::string quoted(std::string_view text) { return fmt::format("\"{}\"", text); }

/// The number that is the whole of a text, or the error: it is none, or its type cannot hold it.
template <typename Number, typename... Format>
std::pair<std::errc, Number> whole_number(std::string_view text, Format... format) {
  Number number{};
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number, format...);
  return {at == end ? error : std::errc::invalid_argument, number};
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

/// The bits of a value that is no text.
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

/// How far up in its value a register is, in bits; `at` counts the `size` registers of the value.
std::size_t shift_of(std::size_t at, std::size_t size, drive::WordOrder order) {
  return 16 * (order == drive::WordOrder::big ? size - 1 - at : at);
}

}  // namespace

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
  if (type == ValueType::f32) {
    return float_text(std::bit_cast<float>(static_cast<std::uint32_t>(bits)));
  }
  if (type == ValueType::f64) {
    return float_text(std::bit_cast<double>(bits));
  }
  if (type == ValueType::text) {
    return text_of({&bits, 1});
  }
  return is_signed(type) ? std::to_string(signed_number(type, bits)) : std::to_string(bits);
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

std::vector<std::uint16_t> to_registers(ValueType type, drive::WordOrder order,
                                        std::span<const std::uint64_t> values) {
  const std::size_t size = width(type);
  std::vector<std::uint16_t> registers;
  registers.reserve(values.size() * size);
  for (const std::uint64_t bits : values) {
    for (std::size_t at = 0; at < size; ++at) {
      registers.push_back(static_cast<std::uint16_t>(bits >> shift_of(at, size, order)));
    }
  }
  return registers;
}

std::vector<std::uint64_t> to_values(ValueType type, drive::WordOrder order,
                                     std::span<const std::uint16_t> registers) {
  const std::size_t size = width(type);
  std::vector<std::uint64_t> values;
  values.reserve(registers.size() / size);
  for (std::size_t first = 0; first + size <= registers.size(); first += size) {
    std::uint64_t bits = 0;
    for (std::size_t at = 0; at < size; ++at) {
      bits |= std::uint64_t{registers[first + at]} << shift_of(at, size, order);
    }
    values.push_back(bits);
  }
  return values;
}

}  // namespace mbgate::ctl
