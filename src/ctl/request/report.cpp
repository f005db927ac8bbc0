// SPDX-License-Identifier: Apache-2.0
#include <bit>
#include <boost/json.hpp>
#include <charconv>
#include <cmath>
#include <fmt/core.h>
#include <ostream>

#include "config/toml/match_entry.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/request/value_text.hpp"

namespace mbgate::ctl {
namespace {

boost::json::string_view json_word(std::string_view word) { return {word.data(), word.size()}; }

/// JSON has no word for what is no number: "nan", "inf", "-inf".
boost::json::value float_json(ValueType type, std::uint64_t bits) {
  const auto words = value_text(type, bits);
  double number = 0;
  std::from_chars(words.data(), words.data() + words.size(), number);
  if (!std::isfinite(number)) {
    return json_word(words);
  }
  // The shortest text of an f32 becomes a double that has it too: 0.1, not 0.10000000149011612.
  if (type == ValueType::f32) {
    const auto exact = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    return static_cast<float>(number) == exact ? number : double{exact};
  }
  return number;
}

boost::json::value value_json(ValueType type, std::uint64_t bits) {
  switch (type) {
    case ValueType::bit: return bits != 0;
    case ValueType::u16:
    case ValueType::u32:
    case ValueType::u64: return bits;
    case ValueType::i16: return static_cast<std::int16_t>(bits);
    case ValueType::i32: return static_cast<std::int32_t>(bits);
    case ValueType::i64: return static_cast<std::int64_t>(bits);
    case ValueType::f32:
    case ValueType::f64: return float_json(type, bits);
    case ValueType::text: return json_word(text_of({&bits, 1}));
  }
  return nullptr;
}

boost::json::object head_json(const Target& target, const Place& place) {
  return {{"unit", target.unit}, {"table", json_word(config::table_word(place.table))}};
}

std::string read_json(const ReadCommand& command, std::span<const std::uint64_t> values) {
  const auto type = command.place.type;
  std::size_t address = command.place.address;
  boost::json::array list;
  if (type == ValueType::text) {
    list.push_back({{"address", address}, {"value", json_word(text_of(values))}});
  } else {
    for (const auto bits : values) {
      list.push_back({{"address", address}, {"value", value_json(type, bits)}});
      address += width(type);
    }
  }
  auto object = head_json(command.target, command.place);
  object["values"] = std::move(list);
  return boost::json::serialize(object);
}

/// Each value with its address, and `end` behind it.
std::string lines_of(const Place& place, std::span<const std::uint64_t> values,
                     std::string_view end) {
  if (place.type == ValueType::text) {
    return fmt::format("{}: \"{}\"{}", place.address, text_of(values), end);
  }
  std::string lines;
  std::size_t address = place.address;
  for (const auto bits : values) {
    lines +=
        fmt::format("{}{}", value_line(static_cast<std::uint16_t>(address), place.type, bits), end);
    address += width(place.type);
  }
  return lines;
}

std::string plain_lines_of(ValueType type, std::span<const std::uint64_t> values) {
  if (type == ValueType::text) {
    return text_of(values) + "\n";
  }
  std::string lines;
  for (const auto bits : values) {
    lines += value_text(type, bits) + "\n";
  }
  return lines;
}

}  // namespace

std::string read_report(const ReadCommand& command, std::span<const std::uint64_t> values) {
  if (command.json) {
    return read_json(command, values) + "\n";
  }
  return command.quiet ? plain_lines_of(command.place.type, values)
                       : lines_of(command.place, values, "\n");
}

std::string write_report(const WriteCommand& command) {
  if (command.json) {
    auto object = head_json(command.target, command.place);
    object["address"] = command.place.address;
    const bool is_text = command.place.type == ValueType::text;
    object["written"] = is_text ? std::size_t{1} : command.values.size();
    return boost::json::serialize(object) + "\n";
  }
  return command.quiet ? std::string() : lines_of(command.place, command.values, " written\n");
}

std::string failure_json(const Failure& failure) {
  boost::json::object object{{"error", json_word(failure.text)}};
  if (failure.exception) {
    object["exception"] = *failure.exception;
  }
  return boost::json::serialize(object);
}

int report_failure(const Failure& failure, bool as_json, std::ostream& out, std::ostream& errors) {
  if (as_json) {
    out << failure_json(failure) << '\n';
  } else {
    errors << "mbgatectl: " << failure.text << '\n';
  }
  return failure.status;
}

}  // namespace mbgate::ctl
