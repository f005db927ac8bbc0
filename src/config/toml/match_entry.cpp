// SPDX-License-Identifier: Apache-2.0
#include "config/toml/match_entry.hpp"

#include <fmt/core.h>
#include <string>

#include "base/text.hpp"

namespace mbgate::config {
namespace {

using modbus::Table;

/// What a function 16 carries besides the stop itself (Application Protocol V1.1b3, 6.12), rounded.
constexpr std::int64_t kMostParameters = 120;

constexpr IntegerRange kValues32 = {0, 0xFFFFFFFF};

template <typename Match>
void check_written(TomlTable& entry, std::string_view key, Table table, const Match& match) {
  if (table == Table::coils) {
    if (match.value != 0 && match.value != kCoilOn) {
      entry.error(key, "a coil is written as 0 or 0xFF00, found {}", match.value);
    }
    if (entry.has("mask")) {
      entry.error("mask", "a coil has no bits to choose from");
    }
  } else if ((match.value & match.mask) != match.value) {
    entry.error(key, "{} has bits outside of the mask, {}", match.value, match.mask);
  }
}

/// `values`: that can be written there.
template <typename Match>
void read_condition(TomlTable& entry, bool or_not, Table table, IntegerRange values, Match& match) {
  assign(match.mask, entry.integer("mask", {1, values.max}));
  const bool not_key = or_not && entry.has("not");
  if (or_not && !not_key && !entry.has("value")) {
    entry.document().error(entry.position(),
                           entry.title() + ": the key 'value' or 'not' is missing");
  } else if (not_key && entry.has("value")) {
    entry.error("not", "expected either 'value' or 'not', not both");
  } else if (!or_not) {
    entry.require("value");
  }
  const std::string_view key = not_key ? "not" : "value";
  match.other = not_key;
  assign(match.value, entry.integer(key, values));
  check_written(entry, key, table, match);
}

}  // namespace

void read_written(TomlTable& entry, bool or_not, drive::WriteMatch& match) {
  read_condition(entry, or_not, match.table, kRegisterValues, match);
}

void read_written(TomlTable& entry, drive::GuardedWrite& guarded) {
  const bool alone = guarded.range.count == 1;
  read_condition(entry, true, guarded.range.table, alone ? kRegisterValues : kValues32, guarded);
}

void read_parameters(TomlTable& entry, drive::WriteMatch& match) {
  assign(match.parameters, entry.integer("parameters", {0, kMostParameters}));
  if (match.parameters == 0) {
    return;
  }
  if (match.table == Table::coils) {
    entry.error("parameters", "a coil has none");
  } else if (match.address + match.parameters > 0xFFFF) {
    entry.error("parameters", "{} registers behind it pass the end of the table", match.parameters);
  }
}

std::optional<std::uint16_t> parse_register_address(std::string_view text) {
  const bool is_hexadecimal = text.starts_with("0x");
  if (is_hexadecimal) {
    text.remove_prefix(2);
  }
  return integer_in<std::uint16_t>(text, is_hexadecimal ? 16 : 10);
}

std::optional<IntegerRange> parse_range(std::string_view text, IntegerRange limits) {
  const auto dash = text.find('-');
  if (dash == std::string_view::npos) {
    return std::nullopt;
  }
  const auto first = integer_in<std::uint32_t>(text.substr(0, dash));
  const auto last = integer_in<std::uint32_t>(text.substr(dash + 1));
  if (!first || !last || *first > *last || *first < limits.min || *last > limits.max) {
    return std::nullopt;
  }
  return IntegerRange{*first, *last};
}

std::optional<UnitRange> read_units(TomlTable& table, std::string_view key, IntegerRange limits) {
  const auto* found = table.value(key);
  if (found == nullptr) {
    return std::nullopt;
  }
  std::optional<IntegerRange> range;
  if (const auto* number = std::get_if<std::int64_t>(&found->data)) {
    if (*number >= limits.min && *number <= limits.max) {
      range = {*number, *number};
    }
  } else if (const auto* text = std::get_if<std::string>(&found->data)) {
    range = parse_range(*text, limits);
  }
  if (!range) {
    const auto* text = std::get_if<std::string>(&found->data);
    const auto quoted = text != nullptr ? integer_in<std::uint32_t>(*text) : std::nullopt;
    table.report_expected(key, *found,
                          quoted && *quoted >= limits.min && *quoted <= limits.max
                              ? *text + " without quotes"
                              : fmt::format("an integer from {} to {} or a range such as \"1-32\"",
                                            limits.min, limits.max));
    return std::nullopt;
  }
  return UnitRange{static_cast<std::uint8_t>(range->min), static_cast<std::uint8_t>(range->max)};
}

}  // namespace mbgate::config
