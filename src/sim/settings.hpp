// SPDX-License-Identifier: Apache-2.0
// What the simulator is told: its buses, what they are linked to and which drives are on them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/diagnostic.hpp"
#include "sim/wire.hpp"

namespace mbgate::sim {

/// Names and meanings are those of conf/demo-sim.toml.
struct BusSettings {
  std::string name;
  std::filesystem::path link;  ///< symbolic link to the pty, made and removed by the simulator
  WireSettings wire;
  std::vector<DeviceSettings> devices;
};

struct Settings {
  /// How long the ptys stay away after SIGUSR2.
  Duration reopen_after = std::chrono::seconds(1);
  std::vector<BusSettings> buses;
};

struct Loaded {
  std::optional<Settings> settings;  ///< none if there is an error among the diagnostics
  std::vector<config::Diagnostic> diagnostics;
};

/// Reads the simulator's configuration; a file that cannot be read is a diagnostic too.
Loaded load_settings(const std::filesystem::path& path);

/// The same for a text; `name` stands in the diagnostics.
Loaded load_settings_text(std::string name, std::string_view text);

}  // namespace mbgate::sim
