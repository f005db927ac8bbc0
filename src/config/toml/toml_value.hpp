// SPDX-License-Identifier: Apache-2.0
// The contents of a TOML text, as plain values with their positions. A table remembers which of its
// keys were read.
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

}  // namespace mbgate::config
