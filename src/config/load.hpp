// SPDX-License-Identifier: Apache-2.0
// The gateway's settings out of its configuration file. Either all of it is right and there are
// settings, or there are none; what is wrong is reported whole, errors of syntax only up to the
// first.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config/diagnostic.hpp"
#include "gateway/settings.hpp"

namespace mbgate::config {

struct Loaded {
  std::optional<gateway::Settings> settings;  ///< none if there is an error among the diagnostics
  std::vector<Diagnostic> diagnostics;        ///< errors and warnings, in the order of the text
};

/// Reads a file; one that cannot be read is a diagnostic too. No port is touched.
Loaded load_settings(const std::filesystem::path& path);

/// The same for a text; `name` stands in the diagnostics.
Loaded load_settings_text(std::string name, std::string_view text);

}  // namespace mbgate::config
