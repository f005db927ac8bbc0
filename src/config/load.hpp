// SPDX-License-Identifier: Apache-2.0
// Reads the gateway's settings from its configuration file. There are settings only if all of the
// file is right. All errors of meaning are reported, but only the first error of syntax.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/diagnostic.hpp"
#include "config/profiles/profile_library.hpp"
#include "gateway/settings.hpp"

namespace mbgate::config {

struct Loaded {
  std::optional<gateway::Settings> settings;  ///< none if there is an error among the diagnostics
  /// Errors and warnings, in the order of the text; then those of the profiles that the file names.
  std::vector<Diagnostic> diagnostics;
};

/// Where to look for the profiles that a configuration names.
struct ProfileSearch {
  std::optional<std::filesystem::path> folder{};  ///< only here, whatever `[gateway] profiles` says
  ProfileFolders otherwise = default_profile_folders();  ///< if neither names a folder
};

/// Reads a file; one that cannot be read is a diagnostic too. No port is touched.
Loaded load_settings(const std::filesystem::path& path, ProfileSearch search = {});

/// The same for a text. `name` is its file name in the diagnostics, and `[gateway] profiles` is
/// relative to its folder.
Loaded load_settings_text(std::string name, std::string_view text, ProfileSearch search = {});

}  // namespace mbgate::config
