// SPDX-License-Identifier: Apache-2.0
// What a TOML text says, as plain values that know where they stand. A table remembers which of its
// keys were asked for.
#pragma once

#include <cstdint>
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
  std::string title;               ///< how a person calls the table: "[[bus]]"
  std::vector<TomlEntry> entries;  ///< in no particular order
  std::vector<std::string> known;  ///< keys that were asked for, present or not
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

/// A string out of a list.
struct TomlText {
  std::string text;
  Position position;
};

/// The value as a diagnostic shows it: `"fast"`, `3`, `true`, `a list`, `a table`.
std::string describe(const TomlValue& value);

bool is_empty_list(const TomlValue& value);

/// The text in quotes, without control characters and not endless.
std::string in_quotes(std::string_view text);

}  // namespace mbgate::config
