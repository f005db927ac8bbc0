// SPDX-License-Identifier: Apache-2.0
// The entries of a profile's lists. Registers are written as the manual counts them and become
// protocol addresses; what is wrong is reported, and the entry left out.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "config/profiles/profile_file.hpp"
#include "config/toml/toml_reader.hpp"

namespace mbgate::config {

using modbus::Table;

/// A profile in the making, and beside what may clash the tables it was read from.
struct ProfileDraft {
  explicit ProfileDraft(TomlDocument& source) : document(source), root(source.root()) {}

  TomlDocument& document;
  TomlTable root;
  ProfileFile file;
  std::vector<TomlTable> value_tables;   ///< beside file.values
  std::vector<TomlTable> string_tables;  ///< beside file.strings
  std::vector<TomlTable> group_tables;   ///< beside file.groups
};

/// `register` (or another key) of an entry as a protocol address.
std::optional<std::uint16_t> read_register(const ProfileFile& file, TomlTable& entry,
                                           std::string_view key, Table table);

/// A list of ranges; `tables` are those that may be named. The tables read are appended to `places`
/// where there is one.
DocumentedRanges read_ranges(const ProfileFile& file, std::vector<TomlTable> entries,
                             std::span<const Word<Table>> tables,
                             std::vector<TomlTable>* places = nullptr);

void read_values(ProfileDraft& draft);
void read_slow(ProfileDraft& draft);
void read_unanswered(ProfileDraft& draft);
void read_stops(ProfileDraft& draft);

/// `line` of the manual.
std::optional<std::uint32_t> read_manual_line(TomlTable& entry);

/// `write_function`: 6 or 16.
std::optional<std::uint8_t> read_write_function(TomlTable& table);

/// What no entry can see alone: values that overlap, leave the map or cross a group, limits that
/// cut a value.
void check_profile(ProfileDraft& draft);

}  // namespace mbgate::config
