// SPDX-License-Identifier: Apache-2.0
// What only a whole profile shows.
#include <algorithm>
#include <fmt/core.h>
#include <string>

#include "config/profiles/profile_entries.hpp"
#include "config/sections/sections.hpp"
#include "config/toml/match_entry.hpp"

namespace mbgate::config {
namespace {

using drive::contains;
using drive::covers;
using drive::overlap;
using drive::TableRange;

std::string numbers(const ProfileFile& file, const TableRange& range) {
  return fmt::format("{} to {}", file.number(range.table, range.first),
                     file.number(range.table, drive::end_of(range) - 1));
}

bool overlaps_another(ProfileDraft& draft, std::size_t at) {
  const auto& file = draft.file;
  const auto range = file.values[at].value.range();
  const auto clash = [&](std::string_view what, TomlTable& other) {
    draft.value_tables[at].error("register", "{} overlap the {} at {}", numbers(file, range), what,
                                 other.place_of("register"));
    return true;
  };
  for (std::size_t i = 0; i < at; ++i) {
    if (overlap(file.values[i].value.range(), range)) {
      return clash("value", draft.value_tables[i]);
    }
  }
  for (std::size_t i = 0; i < file.strings.size(); ++i) {
    if (overlap(file.strings[i].fact, range)) {
      return clash("string", draft.string_tables[i]);
    }
  }
  return false;
}

/// A value that no single request can reach would never be exchanged as one.
void check_value(ProfileDraft& draft, std::size_t at) {
  const auto range = draft.file.values[at].value.range();
  auto& entry = draft.value_tables[at];
  const auto& profile = draft.file.profile;
  if (overlaps_another(draft, at)) {
    return;
  }
  if (profile.is_special(range)) {
    entry.error("register",
                "{} hold a stop, an opcode or its parameters, a communication register, or a write "
                "that is guarded or never answered",
                numbers(draft.file, range));
    return;
  }
  if (profile.input_as_holding && range.table == Table::input_registers) {
    entry.error("table",
                "with input_as_holding, function 04 reads the holding registers: name it there");
  }
  if (!profile.map.empty() && !covers(profile.map, range)) {
    entry.error("register", numbers(draft.file, range) + " are not all in 'map'");
  }
  for (const auto& group : profile.groups) {
    if (overlap(group, range) && !(contains(group, range.table, range.first) &&
                                   contains(group, range.table, drive::end_of(range) - 1))) {
      entry.error("register", "{} cross a border of the group {}", numbers(draft.file, range),
                  numbers(draft.file, group));
      return;
    }
  }
}

/// What is written to a part of a value says nothing of the value.
void check_guarded(ProfileDraft& draft) {
  for (std::size_t at = 0; at < draft.file.guarded.size(); ++at) {
    const auto& range = draft.file.guarded[at].fact.range;
    const auto value = std::ranges::find_if(draft.file.values, [&](const ProfileValue& it) {
      return overlap(it.value.range(), range);
    });
    const bool is_value = value != draft.file.values.end() && value->value.range() == range;
    if (range.count == 2 && !is_value) {
      draft.guarded_tables[at].error("registers",
                                     numbers(draft.file, range) + " are not a value of values32");
    } else if (!is_value && value != draft.file.values.end()) {
      draft.guarded_tables[at].error(
          "register", "{} is a part of the value {}: give its first register, and registers = 2",
          draft.file.number(range.table, range.first), numbers(draft.file, value->value.range()));
    }
  }
}

void check_groups(ProfileDraft& draft) {
  const auto& groups = draft.file.groups;
  for (std::size_t later = 0; later < groups.size(); ++later) {
    for (std::size_t earlier = 0; earlier < later; ++earlier) {
      if (overlap(groups[earlier].fact, groups[later].fact)) {
        draft.group_tables[later].error("register", "{} overlap the group at {}",
                                        numbers(draft.file, groups[later].fact),
                                        draft.group_tables[earlier].place_of("register"));
      }
    }
  }
}

/// The registers of the longest value of a table; 0 if there is none.
std::uint8_t longest_value(const ProfileFile& file, Table table) {
  std::uint8_t longest = 0;
  for (const auto& value : file.values) {
    if (value.value.table == table) {
      longest = std::max(longest, value.value.registers);
    }
  }
  return longest;
}

void check_limit(ProfileDraft& draft, std::string_view key, std::uint16_t limit,
                 std::uint8_t longest) {
  if (limit < longest) {
    auto limits = draft.root.table("limits");
    limits->error(key, "{} would cut a value of {} registers", limit, longest);
  }
}

void check_limits(ProfileDraft& draft) {
  const auto& profile = draft.file.profile;
  const auto holding = longest_value(draft.file, Table::holding_registers);
  const auto input = longest_value(draft.file, Table::input_registers);
  check_limit(draft, "read_holding", profile.limits.read_from(Table::holding_registers), holding);
  check_limit(draft, "read_input", profile.limits.read_from(Table::input_registers), input);
  check_limit(draft, "write_registers", profile.limits.write_registers, holding);
}

void check_word_order(ProfileDraft& draft) {
  const auto& profile = draft.file.profile;
  if (!draft.file.values.empty() && !draft.root.has("word_order")) {
    draft.document.error(draft.root.position(),
                         "the key 'word_order' is missing: there are values");
  }
  if (!draft.root.has("word_order_register")) {
    return;
  }
  auto table = draft.root.table("word_order_register");
  if (table && !profile.word_order_settable) {
    draft.document.error(table->position(),
                         "[word_order_register]: belongs to word_order = \"settable\"");
  }
}

void check_write_function(ProfileDraft& draft) {
  const auto& profile = draft.file.profile;
  if (profile.write_function && !profile.functions.test(*profile.write_function)) {
    draft.root.error("write_function", "{} is not among 'functions'", *profile.write_function);
  }
}

}  // namespace

void check_profile(ProfileDraft& draft) {
  check_groups(draft);
  for (std::size_t at = 0; at < draft.file.values.size(); ++at) {
    check_value(draft, at);
  }
  check_guarded(draft);
  check_limits(draft);
  check_word_order(draft);
  check_write_function(draft);
}

}  // namespace mbgate::config
