// SPDX-License-Identifier: Apache-2.0
// A profile as read from its file: the facts that the gateway needs, with protocol addresses, and
// the facts for people: names, and the line of the manual.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/diagnostic.hpp"
#include "config/text_file.hpp"
#include "drive/profile.hpp"

namespace mbgate::config {

/// The name of an entry and where it comes from.
struct Source {
  std::string name;
  std::optional<std::uint32_t> line;  ///< of the manual's text
  std::string note;                   ///< a misprint that was corrected, or what is uncertain
};

template <typename Fact>
struct Documented {
  Fact fact;
  Source source;
};

enum class ValueAccess : std::uint8_t { read, write, read_write };

struct ProfileValue {
  drive::Value value;
  ValueAccess access = ValueAccess::read_write;
  Source source;
};

using DocumentedRanges = std::vector<Documented<drive::TableRange>>;

struct ProfileFile {
  /// Its read-only and write-only registers include the values that are read-only or write-only.
  drive::Profile profile;
  std::string path;
  std::string description;
  std::string manual;
  std::string section;
  std::string lines;
  /// The manual's number of protocol address 0, by modbus::Table.
  std::array<std::uint32_t, 4> numbering{};
  DocumentedRanges map;
  DocumentedRanges groups;
  std::vector<ProfileValue> values;  ///< by table and address
  DocumentedRanges strings;
  DocumentedRanges read_only;   ///< without values
  DocumentedRanges write_only;  ///< without values
  DocumentedRanges communication;
  std::vector<Documented<drive::GuardedWrite>> guarded;  ///< of `communication`, with values
  std::vector<Documented<drive::SlowRegisters>> slow;
  std::vector<Documented<drive::UnansweredWrite>> unanswered;
  std::vector<Documented<drive::WriteMatch>> stops;
  DocumentedRanges broadcast_allowed;
  std::optional<std::uint32_t> word_order_line;
  std::optional<std::uint32_t> position_opcodes_line;

  /// The register number as the manual prints it: "40005", or in hexadecimal, "0x00C8", if the
  /// manual counts from 0.
  [[nodiscard]] std::string number(modbus::Table table, std::uint32_t address) const;
};

struct LoadedProfile {
  std::optional<ProfileFile> file;  ///< none if there is an error among the diagnostics
  std::vector<Diagnostic> diagnostics;
};

/// Reads a file; `name` in it must be the name of the file without ".toml".
LoadedProfile load_profile(const TextFile& file);

}  // namespace mbgate::config
