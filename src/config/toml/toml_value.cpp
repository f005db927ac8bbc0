// SPDX-License-Identifier: Apache-2.0
#include "config/toml/toml_value.hpp"

#include <algorithm>
#include <array>
#include <fmt/core.h>

namespace mbgate::config {
namespace {

/// As much of a wrong value as is needed to recognise it.
constexpr std::size_t kMostShown = 60;

struct Describe {
  std::string operator()(const std::string& text) const { return in_quotes(text); }
  std::string operator()(std::int64_t number) const { return std::to_string(number); }
  std::string operator()(double number) const { return fmt::format("{:.12g}", number); }
  std::string operator()(bool truth) const { return truth ? "true" : "false"; }
  std::string operator()(const std::vector<TomlValue>& /*list*/) const { return "a list"; }
  std::string operator()(const TomlTableValue& /*table*/) const { return "a table"; }
  std::string operator()(const TomlOther& /*other*/) const { return "a date or time"; }
};

struct Unit {
  std::string_view name;
  std::int64_t nanoseconds;
};

constexpr std::array kDurationUnits = {
    Unit{"h", 3'600'000'000'000}, Unit{"m", 60'000'000'000}, Unit{"s", 1'000'000'000},
    Unit{"ms", 1'000'000},        Unit{"us", 1'000},
};
constexpr std::int64_t kLongest = 1000 * kDurationUnits[0].nanoseconds;

/// A double holds the nanoseconds of all durations that can be parsed.
std::string decimal(std::int64_t nanoseconds, const Unit& unit) {
  return fmt::format(
      "{}{}", static_cast<double>(nanoseconds) / static_cast<double>(unit.nanoseconds), unit.name);
}

}  // namespace

std::string describe(const TomlValue& value) { return std::visit(Describe{}, value.data); }

bool is_empty_list(const TomlValue& value) {
  const auto* list = std::get_if<std::vector<TomlValue>>(&value.data);
  return list != nullptr && list->empty();
}

std::string in_quotes(std::string_view text) {
  std::string shown = "\"";
  for (const char byte : text) {
    const auto code = static_cast<unsigned char>(byte);
    const bool starts_character = (code & 0xC0U) != 0x80U;
    if (shown.size() > kMostShown && starts_character) {
      return shown + "...\"";
    }
    if (byte == '\n') {
      shown += "\\n";
    } else if (byte == '\t') {
      shown += "\\t";
    } else {
      shown += code < 0x20U || code == 0x7FU ? '?' : byte;
    }
  }
  return shown + "\"";
}

std::optional<std::chrono::nanoseconds> parse_duration(std::string_view text) {
  const auto number = text.substr(0, text.find_first_not_of("0123456789."));
  const auto* const unit =
      std::ranges::find(kDurationUnits, text.substr(number.size()), &Unit::name);
  const auto point = std::min(number.find('.'), number.size());
  if (unit == kDurationUnits.end() || point == 0 || point + 1 == number.size() ||
      std::ranges::count(number, '.') > 1) {
    return std::nullopt;
  }
  std::int64_t sum = 0;
  // Each decimal is worth a tenth of the digit before; what is left below a nanosecond must be
  // zeros.
  std::int64_t worth = unit->nanoseconds;
  for (std::size_t at = 0; at < number.size(); ++at) {
    const std::int64_t digit = number[at] - '0';
    if (at < point) {
      sum = 10 * sum + digit * unit->nanoseconds;
    } else if (at > point) {
      if (digit * worth % 10 != 0) {
        return std::nullopt;
      }
      sum += digit * worth / 10;
      worth = worth % 10 == 0 ? worth / 10 : 1;  // 1: only zeros may follow
    }
    if (sum > kLongest) {
      return std::nullopt;
    }
  }
  return std::chrono::nanoseconds(sum);
}

std::string to_text(std::chrono::nanoseconds duration) {
  const std::int64_t count = duration.count();
  if (count == 0) {
    return "0s";
  }
  const Unit& millisecond = kDurationUnits[3];
  const Unit& microsecond = kDurationUnits[4];
  for (const auto& unit : kDurationUnits) {
    if (unit.nanoseconds >= millisecond.nanoseconds && count % unit.nanoseconds == 0) {
      return decimal(count, unit);
    }
  }
  return decimal(count, count > millisecond.nanoseconds ? millisecond : microsecond);
}

}  // namespace mbgate::config
