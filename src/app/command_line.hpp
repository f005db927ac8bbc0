// SPDX-License-Identifier: Apache-2.0
// The arguments of mbgated.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>

namespace mbgate::app {

struct Options {
  std::filesystem::path config = "/etc/mbgate/mbgate.toml";
  /// The only folder to look for profiles in, whatever the configuration says.
  std::optional<std::filesystem::path> profiles;
  /// Record the machine's inputs and actions to this file.
  std::optional<std::filesystem::path> record;
  bool check = false;  ///< validate the configuration and exit
};

/// The options, or the exit status when help, version, keys or an error has been printed already.
std::variant<Options, int> parse_command_line(int argc, const char* const* argv,
                                              const std::string& version);

}  // namespace mbgate::app
