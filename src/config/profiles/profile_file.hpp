// SPDX-License-Identifier: Apache-2.0
// A profile out of its file: what the gateway needs to know of a kind of drive, with protocol
// addresses, and beside it what people want to know: names, and where in the manual it stands.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/diagnostic.hpp"
#include "drive/profile.hpp"

namespace mbgate::config {

/// What an entry is called and where it comes from.
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
  /// Its read-only and write-only registers include the values that are so.
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
  std::vector<Documented<drive::SlowRegisters>> slow;
  std::vector<Documented<drive::UnansweredWrite>> unanswered;
  std::vector<Documented<drive::WriteMatch>> stops;
  DocumentedRanges broadcast_allowed;
  std::optional<std::uint32_t> word_order_line;
  std::optional<std::uint32_t> position_opcodes_line;

  /// As the manual prints it: "40005"; in hexadecimal, "0x00C8", where it counts from 0.
  [[nodiscard]] std::string number(modbus::Table table, std::uint32_t address) const;
};

struct LoadedProfile {
  std::optional<ProfileFile> file;  ///< none if there is an error among the diagnostics
  std::vector<Diagnostic> diagnostics;
};

/// Reads a file; `name` in it must be the file's own, without ".toml".
LoadedProfile load_profile(const std::filesystem::path& path);

/// The same for a text; `path` stands in the diagnostics.
LoadedProfile load_profile_text(std::string path, std::string_view text);

}  // namespace mbgate::config
