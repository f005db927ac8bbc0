// SPDX-License-Identifier: Apache-2.0
// A profile as text, for people: what the gateway knows of a drive, with the lines of the manual.
#pragma once

#include <bitset>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/profiles/profile_file.hpp"
#include "config/profiles/profile_library.hpp"
#include "modbus/describe.hpp"

namespace mbgate::ctl {

/// The numbers from 1 on whose bits are set: function codes, exceptions.
template <std::size_t Size>
std::vector<unsigned> codes_in(const std::bitset<Size>& set) {
  std::vector<unsigned> codes;
  for (unsigned code = 1; code < Size; ++code) {
    if (set.test(code)) {
      codes.push_back(code);
    }
  }
  return codes;
}

/// "0x00C8"
std::string hex(unsigned number);
/// A line of the manual, or nothing.
std::string line_text(const std::optional<std::uint32_t>& line);
/// Register numbers as in the manual: "40005", "40005-40006".
std::string number_text(const config::ProfileFile& file, const drive::TableRange& range);

/// What concerns the whole drive.
std::string profile_head(const config::ProfileFile& file);

/// The whole profile, each line ended by a newline.
std::string profile_text(const config::ProfileFile& file);

// A profile as JSON, for programs. Addresses are protocol addresses.

/// One line: {"name": ..., "values32": {"holding": [first addresses], "input": [...]}, ...};
/// everything else (names, the manual's register numbers and lines, notes) is in "entries".
std::string profile_json(const config::ProfileFile& file);

/// One line: [{"name": ..., "description": ...}, ...]
std::string profiles_json(const std::vector<const config::ProfileFile*>& files);

/// Those of a library that have no errors, by name.
std::vector<const config::ProfileFile*> all_profiles(config::ProfileLibrary& library);

}  // namespace mbgate::ctl
