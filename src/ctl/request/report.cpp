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

/// JSON has no word for what is no number: "nan", "inf", "-inf".
boost::json::value float_json(ValueType type, std::uint64_t bits) {
  const auto words = value_text(type, bits);
  double number = 0;
  std::from_chars(words.data(), words.data() + words.size(), number);
  if (!std::isfinite(number)) {
    return boost::json::value(words);
  }
  // The shortest text of an f32 becomes a double that has it too: 0.1, not 0.10000000149011612.
  if (type == ValueType::f32) {
    const auto exact = std::bit_cast<float>(static_cast<std::uint32_t>(bits));
    return static_cast<float>(number) == exact ? number : double{exact};
  }
  return number;
}

boost::json::value value_json(ValueType type, std::span<const std::uint64_t> value) {
  if (type == ValueType::bit) {
    return value.front() != 0;
  }
  if (type == ValueType::f32 || type == ValueType::f64) {
    return float_json(type, value.front());
  }
  return type == ValueType::text ? boost::json::value(text_of(value))
                                 : boost::json::parse(value_text(type, value.front()));
}

/// Calls `show` with the address of each value, and the value; a text is one value.
template <typename Show>
void each_value(const Place& place, std::span<const std::uint64_t> values, const Show& show) {
  const std::size_t size = place.type == ValueType::text ? values.size() : 1;
  for (std::size_t at = 0; at < values.size(); at += size) {
    show(place.address + at * width(place.type), values.subspan(at, size));
  }
}

boost::json::object head_json(const Target& target, const Place& place) {
  return {{"unit", target.unit}, {"table", config::table_word(place.table)}};
}

std::string read_json(const ReadCommand& command, std::span<const std::uint64_t> values) {
  boost::json::array list;
  each_value(command.place, values, [&](std::size_t address, auto value) {
    list.push_back(boost::json::object{{"address", address},
                                       {"value", value_json(command.place.type, value)}});
  });
  auto object = head_json(command.target, command.place);
  object["values"] = std::move(list);
  return boost::json::serialize(object);
}

/// Each value with its address, and `end` behind it.
std::string lines_of(const Place& place, std::span<const std::uint64_t> values,
                     std::string_view end) {
  std::string lines;
  each_value(place, values, [&](std::size_t address, auto value) {
    lines += place.type == ValueType::text
                 ? fmt::format("{}: \"{}\"", address, text_of(value))
                 : value_line(static_cast<std::uint16_t>(address), place.type, value.front());
    lines += end;
  });
  return lines;
}

std::string plain_lines_of(const Place& place, std::span<const std::uint64_t> values) {
  std::string lines;
  each_value(place, values, [&](std::size_t /*address*/, auto value) {
    lines += place.type == ValueType::text ? text_of(value) : value_text(place.type, value.front());
    lines += "\n";
  });
  return lines;
}

}  // namespace

std::string read_report(const ReadCommand& command, std::span<const std::uint64_t> values) {
  if (command.json) {
    return read_json(command, values) + "\n";
  }
  return command.quiet ? plain_lines_of(command.place, values)
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

int report_failure(const Failure& failure, bool as_json, std::ostream& out, std::ostream& errors) {
  if (as_json) {
    boost::json::object object{{"error", failure.text}};
    if (failure.exception) {
      object["exception"] = *failure.exception;
    }
    out << boost::json::serialize(object) << '\n';
  } else {
    errors << "mbgatectl: " << failure.text << '\n';
  }
  return failure.status;
}

}  // namespace mbgate::ctl
