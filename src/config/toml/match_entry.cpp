// SPDX-License-Identifier: Apache-2.0
#include "config/toml/match_entry.hpp"

#include <string>

#include "config/toml/words.hpp"

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
      entry.error(key, "a coil is written as 0 or 0xFF00, found " + std::to_string(match.value));
    }
    if (entry.has("mask")) {
      entry.error("mask", "a coil has no bits to choose from");
    }
  } else if ((match.value & match.mask) != match.value) {
    entry.error(key, std::to_string(match.value) + " has bits outside of the mask, " +
                         std::to_string(match.mask));
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
    entry.error("not", "either 'value' or 'not' says which writes are meant, not both");
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
    entry.error("parameters", std::to_string(match.parameters) +
                                  " registers behind it pass the end of the table");
  }
}

}  // namespace mbgate::config
