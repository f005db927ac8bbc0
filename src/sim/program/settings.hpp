// SPDX-License-Identifier: Apache-2.0
// The settings of the simulator: its buses, where they can be reached, and which drives are on
// them.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "config/diagnostic.hpp"
#include "config/text_file.hpp"
#include "sim/program/tcp_port.hpp"
#include "sim/wire/wire.hpp"

namespace mbgate::sim {

enum class BusMode : std::uint8_t {
  rtu,
  ascii,
  tcp  ///< drives on Ethernet: no wire
};

/// Names and meanings are those of conf/demo-sim.toml.
struct BusSettings {
  std::string name;
  BusMode mode = BusMode::rtu;
  /// Symbolic link to the pty, created and removed by the simulator.
  std::filesystem::path link{};
  /// Where it listens: always set for a TCP bus; for others, set in place of the link.
  std::optional<ListenAddress> listen{};
  WireSettings wire{};
  std::vector<DeviceSettings> devices{};
};

struct Settings {
  /// How long ptys and sockets are closed after SIGUSR2.
  Duration reopen_after = std::chrono::seconds(1);
  std::vector<BusSettings> buses;
};

struct Loaded {
  std::optional<Settings> settings;  ///< none if there is an error among the diagnostics
  std::vector<config::Diagnostic> diagnostics;
};

/// Reads the simulator's configuration; a file that could not be read is a diagnostic too.
Loaded load_settings(const config::TextFile& file);

}  // namespace mbgate::sim
