// SPDX-License-Identifier: Apache-2.0
#include "config/toml/unit_range.hpp"

#include <charconv>

namespace mbgate::config {
namespace {

std::optional<std::int64_t> parse_number(std::string_view text) {
  std::uint32_t number = 0;
  const auto* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  return error == std::errc{} && at == end ? std::optional<std::int64_t>(number) : std::nullopt;
}

}  // namespace

std::optional<IntegerRange> parse_range(std::string_view text, IntegerRange limits) {
  const auto dash = text.find('-');
  if (dash == std::string_view::npos) {
    return std::nullopt;
  }
  const auto first = parse_number(text.substr(0, dash));
  const auto last = parse_number(text.substr(dash + 1));
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
    const auto quoted = text != nullptr ? parse_number(*text) : std::nullopt;
    table.report_expected(key, *found,
                          quoted && *quoted >= limits.min && *quoted <= limits.max
                              ? *text + " without quotes"
                              : "an integer from " + std::to_string(limits.min) + " to " +
                                    std::to_string(limits.max) + " or a range such as \"1-32\"");
    return std::nullopt;
  }
  return UnitRange{static_cast<std::uint8_t>(range->min), static_cast<std::uint8_t>(range->max)};
}

}  // namespace mbgate::config
