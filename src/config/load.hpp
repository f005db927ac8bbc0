// SPDX-License-Identifier: Apache-2.0
// Reads the gateway's settings from the files of its configuration. There are settings only if
// there is no error. Of syntax errors only the first in each file is reported, and then no other
// errors; otherwise all errors are.
//
// To change
// - the output of mbgatectl check and mbgated --check: load, check_summary; printed by
//   ctl/request/carry_out, app/mbgated.
// - which files the configuration has: text_file; how they become one: toml/toml_document; their
//   digest: app/configuration/digest; in a recording: ConfigFile in report/recording/record.
// - which listeners are refused because they would let everyone in: an address:
//   sections/listener_section; a socket from systemd: io/clients/listening_socket.
// - deadlines: the defaults, and which are too short: gateway/limits, checks/whole_checks.
// - two buses that lead to one line: sections/bus_section; if this shows only at opening:
//   io/lines/open_ends.
// - suggestions for keys that other programs name differently: toml/suggestion.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/diagnostic.hpp"
#include "config/profiles/profile_library.hpp"
#include "config/text_file.hpp"
#include "gateway/settings.hpp"

namespace mbgate::config {

struct Loaded {
  std::optional<gateway::Settings> settings;  ///< none if there is an error among the diagnostics
  /// Errors and warnings, in the order of the files and of their texts; then those of the profiles
  /// that they name.
  std::vector<Diagnostic> diagnostics;
  KeyPlaces places{};  ///< beside the settings
  /// The files of the profiles that the devices use, by the names of the profiles.
  std::vector<TextFile> profiles{};
};

/// Where to look for the profiles that a configuration names.
struct ProfileSearch {
  std::optional<std::filesystem::path> folder{};  ///< only here, whatever `[gateway] profiles` says
  ProfileFolders otherwise = default_profile_folders();  ///< if neither names a folder
};

/// Reads the main file and those of conf.d beside it (read_config_files()); what cannot be read is
/// a diagnostic too. No port is touched.
Loaded load_settings(const std::filesystem::path& path, ProfileSearch search = {});

/// The same for files that were read before, at least one. `[gateway] profiles` is relative to the
/// folder of the file that it stands in.
Loaded load_settings(const std::vector<TextFile>& files, ProfileSearch search = {});

/// What --check prints for a configuration without errors: "configuration ok: 2 listeners, 1 bus,
/// 3 devices, 2 routes", and a line for each of its needs. `settings`: as they were read.
std::string check_summary(const gateway::Settings& settings);

// What a configuration needs from the system beyond the service as it is shipped, such as a port
// below 1024. Derived from the settings; nothing is tried.

/// "needs port 502 (listener "plant"): mbgated.socket, or the drop-in port-502.conf". None for a
/// configuration without needs.
std::vector<std::string> needs(const gateway::Settings& settings);

}  // namespace mbgate::config
