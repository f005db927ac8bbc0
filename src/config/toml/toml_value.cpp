// SPDX-License-Identifier: Apache-2.0
#include "config/toml/toml_value.hpp"

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

bool is_digit(char c) { return c >= '0' && c <= '9'; }

std::size_t count_digits(std::string_view text) {
  std::size_t count = 0;
  while (count < text.size() && is_digit(text[count])) {
    ++count;
  }
  return count;
}

const Unit* find_unit(std::string_view name) {
  for (const auto& unit : kDurationUnits) {
    if (unit.name == name) {
      return &unit;
    }
  }
  return nullptr;
}

std::optional<std::int64_t> whole_part(std::string_view digits, std::int64_t unit) {
  std::int64_t value = 0;
  for (const char digit : digits) {
    value = value * 10 + (digit - '0');
    if (value > kLongest / unit) {
      return std::nullopt;
    }
  }
  return value * unit;
}

/// Each digit is worth a tenth of the one before; what is left below a nanosecond must be zeros.
std::optional<std::int64_t> fraction(std::string_view digits, std::int64_t unit) {
  std::int64_t value = 0;
  for (const char digit : digits) {
    const std::int64_t worth = (digit - '0') * unit;
    if (worth % 10 != 0) {
      return std::nullopt;
    }
    value += worth / 10;
    unit = unit % 10 == 0 ? unit / 10 : 1;  // 1: only zeros may follow
  }
  return value;
}

std::string decimal(std::int64_t nanoseconds, const Unit& unit) {
  std::string text = std::to_string(nanoseconds / unit.nanoseconds);
  std::int64_t rest = nanoseconds % unit.nanoseconds;
  if (rest != 0) {
    text += '.';
  }
  for (std::int64_t worth = unit.nanoseconds / 10; rest != 0; worth /= 10) {
    text += static_cast<char>('0' + rest / worth);
    rest %= worth;
  }
  return text + std::string(unit.name);
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
  const auto whole = text.substr(0, count_digits(text));
  text.remove_prefix(whole.size());
  std::string_view decimals;
  if (text.starts_with('.')) {
    text.remove_prefix(1);
    decimals = text.substr(0, count_digits(text));
    text.remove_prefix(decimals.size());
    if (decimals.empty()) {
      return std::nullopt;
    }
  }
  const Unit* unit = find_unit(text);
  if (whole.empty() || unit == nullptr) {
    return std::nullopt;
  }
  const auto first = whole_part(whole, unit->nanoseconds);
  const auto second = fraction(decimals, unit->nanoseconds);
  if (!first || !second || *first + *second > kLongest) {
    return std::nullopt;
  }
  return std::chrono::nanoseconds(*first + *second);
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
