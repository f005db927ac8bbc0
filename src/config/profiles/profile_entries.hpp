// SPDX-License-Identifier: Apache-2.0
// Reads the entries of a profile's lists. Register numbers are those of the manual, and become
// protocol addresses. A wrong entry is reported and left out.
#pragma once

#include <array>
#include <bitset>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include "config/profiles/profile_file.hpp"
#include "config/toml/toml_reader.hpp"

namespace mbgate::config {

using modbus::Table;

/// Who may do what with a value.
inline constexpr std::array kAccesses = {Word{"r", ValueAccess::read},
                                         Word{"w", ValueAccess::write},
                                         Word{"rw", ValueAccess::read_write}};

/// A profile that is being read. For entries that may clash it also has the tables that they were
/// read from.
struct ProfileDraft {
  explicit ProfileDraft(TomlDocument& source) : document(source), root(source.root()) {}

  TomlDocument& document;
  TomlTable root;
  ProfileFile file;
  std::vector<TomlTable> value_tables;    ///< beside file.values
  std::vector<TomlTable> string_tables;   ///< beside file.strings
  std::vector<TomlTable> group_tables;    ///< beside file.groups
  std::vector<TomlTable> guarded_tables;  ///< beside file.guarded
};

/// `register` (or another key) of an entry as a protocol address.
std::optional<std::uint16_t> read_register(const ProfileFile& file, TomlTable& entry,
                                           std::string_view key, Table table);

/// A list of ranges. `tables`: the Modbus tables that may be named. The TOML tables that were read
/// are appended to `places`, unless it is nullptr.
DocumentedRanges read_ranges(const ProfileFile& file, std::vector<TomlTable> entries,
                             std::span<const Word<Table>> tables,
                             std::vector<TomlTable>* places = nullptr);

void read_values(ProfileDraft& draft);
/// `communication`: registers of which each write is guarded, or those of certain values.
void read_communication(ProfileDraft& draft);
void read_slow(ProfileDraft& draft);
void read_unanswered(ProfileDraft& draft);
void read_stops(ProfileDraft& draft);

/// `line` of the manual.
std::optional<std::uint32_t> read_manual_line(TomlTable& entry);

/// `write_function`: 6 or 16.
std::optional<std::uint8_t> read_write_function(TomlTable& table);

/// Checks that need several entries: values that overlap, leave the map or cross a group; limits
/// that cut a value.
void check_profile(ProfileDraft& draft);

/// A list of codes from 1 to the last that the set can hold; false: there is no such list.
template <std::size_t Size>
bool read_set(TomlTable& root, std::string_view key, std::string_view kind,
              std::bitset<Size>& codes) {
  const auto* elements = root.list(key);
  if (elements == nullptr) {
    return false;
  }
  codes.reset();
  for (const auto& element : *elements) {
    const auto* code = std::get_if<std::int64_t>(&element.data);
    if (code == nullptr || *code < 1 || *code >= static_cast<std::int64_t>(Size)) {
      root.report_expected(key, element, "{} code from 1 to {}", kind, Size - 1);
    } else {
      codes.set(static_cast<std::size_t>(*code));
    }
  }
  return true;
}

}  // namespace mbgate::config
