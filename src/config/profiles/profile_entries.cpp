// SPDX-License-Identifier: Apache-2.0
#include "config/profiles/profile_entries.hpp"

#include <array>
#include <limits>

#include "config/toml/match_entry.hpp"

namespace mbgate::config {
namespace {

using namespace std::chrono_literals;

constexpr std::int64_t kMaxNumber = std::numeric_limits<std::uint32_t>::max();
constexpr std::uint32_t kLastAddress = 0xFFFF;

Source read_source(TomlTable& entry) {
  Source source;
  assign(source.name, entry.string("name"));
  source.line = read_manual_line(entry);
  assign(source.note, entry.string("note"));
  return source;
}

/// The table that the entry names; nothing if it names a wrong one.
std::optional<Table> read_table(TomlTable& entry, std::span<const Word<Table>> tables) {
  if (!entry.has("table")) {
    return Table::holding_registers;
  }
  return entry.word<Table>("table", tables);
}

/// `count` registers from `register` on.
std::optional<drive::TableRange> read_range(const ProfileFile& file, TomlTable& entry,
                                            std::span<const Word<Table>> tables,
                                            std::optional<std::int64_t> count) {
  entry.require("register");
  const auto table = read_table(entry, tables);
  if (!table) {
    return std::nullopt;  // nobody knows how it is counted
  }
  const auto first = read_register(file, entry, "register", *table);
  if (!first || !count) {
    return std::nullopt;
  }
  if (*first + *count - 1 > kLastAddress) {
    entry.error("register", "{} registers from {} on pass {}, the last of the table", *count,
                file.number(*table, *first), file.number(*table, kLastAddress));
    return std::nullopt;
  }
  return drive::TableRange{*table, *first, static_cast<std::uint16_t>(*count)};
}

std::optional<drive::TableRange> read_counted_range(const ProfileFile& file, TomlTable& entry,
                                                    std::span<const Word<Table>> tables) {
  const bool counted = entry.has("registers");
  const auto count = entry.integer("registers", {1, kLastAddress});
  return read_range(file, entry, tables, counted ? count : 1);
}

void read_values_of(ProfileDraft& draft, std::string_view key, std::uint8_t registers) {
  for (auto& entry : draft.root.tables(key)) {
    ProfileValue read;
    const auto range = read_range(draft.file, entry, kRegisterTables, registers);
    assign(read.access, entry.word<ValueAccess>("access", kAccesses));
    assign(read.value.motion, entry.boolean("motion"));
    read.source = read_source(entry);
    if (range) {
      read.value.table = range->table;
      read.value.first = range->first;
      read.value.registers = registers;
      draft.file.values.push_back(std::move(read));
      draft.value_tables.push_back(entry);
    }
  }
}

std::optional<drive::WriteMatch> read_match(const ProfileFile& file, TomlTable& entry,
                                            bool or_not) {
  drive::WriteMatch match;
  const auto range = read_range(file, entry, kWritableTables, 1);
  if (range) {
    match.table = range->table;
    match.address = range->first;
  }
  read_written(entry, or_not, match);
  return range ? std::optional(match) : std::nullopt;
}

/// A register or coil with `value` or `not`, or a value of 32 bits.
void read_guarded(ProfileDraft& draft, TomlTable& entry) {
  const auto range = read_counted_range(draft.file, entry, kWritableTables);
  drive::GuardedWrite guarded{range.value_or(drive::TableRange{Table::holding_registers, 0, 1})};
  if (guarded.range.count > 2 ||
      (guarded.range.count == 2 && guarded.range.table == Table::coils)) {
    entry.error("registers",
                "{} registers do not hold one value: expected 1, or 2 for a value of values32",
                guarded.range.count);
    return;
  }
  read_written(entry, guarded);
  auto source = read_source(entry);
  if (range) {
    draft.file.guarded.push_back({guarded, std::move(source)});
    draft.guarded_tables.push_back(entry);
  }
}

}  // namespace

std::optional<std::uint32_t> read_manual_line(TomlTable& entry) {
  const auto line = entry.integer("line", {1, kMaxNumber});
  return line ? std::optional(static_cast<std::uint32_t>(*line)) : std::nullopt;
}

std::optional<std::uint8_t> read_write_function(TomlTable& table) {
  const auto* found = table.value("write_function");
  if (found == nullptr) {
    return std::nullopt;
  }
  const auto* number = std::get_if<std::int64_t>(&found->data);
  if (number == nullptr || (*number != 6 && *number != 16)) {
    table.report_expected("write_function", *found, "6 or 16");
    return std::nullopt;
  }
  return static_cast<std::uint8_t>(*number);
}

std::optional<std::uint16_t> read_register(const ProfileFile& file, TomlTable& entry,
                                           std::string_view key, Table table) {
  const auto number = entry.integer(key, {0, kMaxNumber});
  if (!number) {
    return std::nullopt;
  }
  const auto numbering = file.numbering.at(static_cast<std::size_t>(table));
  if (*number < numbering) {
    entry.error(key, "{} is below {}, where the table begins ([numbering] {})", *number, numbering,
                table_word(table));
    return std::nullopt;
  }
  if (*number > numbering + kLastAddress) {
    entry.error(key, "{} is beyond {}, where the table ends", *number, numbering + kLastAddress);
    return std::nullopt;
  }
  return static_cast<std::uint16_t>(*number - numbering);
}

DocumentedRanges read_ranges(const ProfileFile& file, std::vector<TomlTable> entries,
                             std::span<const Word<Table>> tables, std::vector<TomlTable>* places) {
  DocumentedRanges ranges;
  for (auto& entry : entries) {
    const auto range = read_counted_range(file, entry, tables);
    auto source = read_source(entry);
    if (range) {
      ranges.push_back({*range, std::move(source)});
      if (places != nullptr) {
        places->push_back(entry);
      }
    }
  }
  return ranges;
}

void read_values(ProfileDraft& draft) {
  read_values_of(draft, "values32", 2);
  read_values_of(draft, "values64", 4);
}

void read_communication(ProfileDraft& draft) {
  std::vector<TomlTable> whole;
  for (auto& entry : draft.root.tables("communication")) {
    if (entry.has("mask") || entry.has("value") || entry.has("not")) {
      read_guarded(draft, entry);
    } else {
      whole.push_back(entry);
    }
  }
  draft.file.communication = read_ranges(draft.file, std::move(whole), kWritableTables);
}

void read_slow(ProfileDraft& draft) {
  for (auto& entry : draft.root.tables("slow")) {
    const auto range = read_counted_range(draft.file, entry, kTables);
    entry.require("response_timeout");
    const auto timeout = entry.duration("response_timeout", {1ms, 1h});
    auto source = read_source(entry);
    if (range && timeout) {
      draft.file.slow.push_back({{*range, *timeout}, std::move(source)});
    }
  }
}

void read_unanswered(ProfileDraft& draft) {
  for (auto& entry : draft.root.tables("no_answer")) {
    const auto match = read_match(draft.file, entry, true);
    entry.require("after");
    const auto after = entry.duration("after", {0s, 1h});
    auto source = read_source(entry);
    if (match && after) {
      draft.file.unanswered.push_back({{*match, *after}, std::move(source)});
    }
  }
}

void read_stops(ProfileDraft& draft) {
  for (auto& entry : draft.root.tables("stops")) {
    auto match = read_match(draft.file, entry, false);
    drive::WriteMatch placeless;
    read_parameters(entry, match ? *match : placeless);
    auto source = read_source(entry);
    if (match) {
      draft.file.stops.push_back({*match, std::move(source)});
    }
  }
}

}  // namespace mbgate::config
