// SPDX-License-Identifier: Apache-2.0
// mbgatectl scan: what the operator asks for, and its carrying out over a real connection.
#pragma once

#include <filesystem>
#include <iosfwd>
#include <optional>

#include "config/profile_library.hpp"
#include "ctl/scan.hpp"

namespace mbgate::ctl {

struct ScanCommand {
  Target target;  ///< its unit means nothing here
  std::vector<std::uint8_t> units;
  config::ProfileFolders profiles = config::default_profile_folders();
  std::string bus = "line-a";                   ///< its name in the configuration
  std::optional<std::filesystem::path> config;  ///< standard output if there is none
  bool show_progress = false;                   ///< on the stream of errors
};

/// The table of what was found goes to `out`, and the configuration behind it or into its file,
/// which must not exist yet. Returns the exit status: kExitDone if anything was found.
int carry_out_scan(const ScanCommand& command, std::ostream& out, std::ostream& errors);

/// What the device or the gateway said, as the scan sees it.
Answer answer_of(const modbus::TableRange& read, const modbus::Pdu& response);

}  // namespace mbgate::ctl
