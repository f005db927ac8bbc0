// SPDX-License-Identifier: Apache-2.0
// The contents of a TOML text, as plain values with their positions. A table remembers which of its
// keys were read.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "config/diagnostic.hpp"

namespace mbgate::config {

struct TomlValue;
struct TomlEntry;

struct TomlTableValue {
  Position position;
  std::string title;               ///< the table as written in the file: "[[bus]]"
  std::vector<TomlEntry> entries;  ///< in no particular order
  std::vector<std::string> known;  ///< keys that were read, present or not
};

/// Dates and times, which no setting uses.
struct TomlOther {};

struct TomlValue {
  Position position;
  std::variant<std::string, std::int64_t, double, bool, std::vector<TomlValue>, TomlTableValue,
               TomlOther>
      data;
};

struct TomlEntry {
  std::string key;
  Position position;  ///< of the key
  TomlValue value;
};

/// A string from a list.
struct TomlText {
  std::string text;
  Position position;
};

/// The value as a diagnostic shows it: `"fast"`, `3`, `true`, `a list`, `a table`.
std::string describe(const TomlValue& value);

bool is_empty_list(const TomlValue& value);

/// The text in quotes, without control characters and limited in length.
std::string in_quotes(std::string_view text);

// Durations as text: a decimal number and its unit, "1.75ms". Exact in both directions.

/// "250us", "1.75ms", "2s", "10m", "1h". Nothing for a missing unit, a sign, a space, an exponent,
/// a value finer than a nanosecond, or one longer than 1000 hours.
std::optional<std::chrono::nanoseconds> parse_duration(std::string_view text);

/// In the largest unit that needs no fraction. If that would be nanoseconds, as a decimal fraction
/// of ms or us. `duration` is not negative.
std::string to_text(std::chrono::nanoseconds duration);

}  // namespace mbgate::config
