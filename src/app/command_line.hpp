// SPDX-License-Identifier: Apache-2.0
// The arguments of mbgated.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "app/who/who_options.hpp"

namespace mbgate::app {

struct Options {
  /// The configuration file, or "--serial" where there is `text` in its place: its name in
  /// diagnostics.
  std::filesystem::path config = "/etc/mbgate/mbgate.toml";
  /// The configuration that --serial and the options with it stand for.
  std::optional<std::string> text;
  /// The only folder to look for profiles in, whatever the configuration says.
  std::optional<std::filesystem::path> profiles;
  /// Record the machine's inputs and actions to this file.
  std::optional<std::filesystem::path> record;
  bool check = false;             ///< validate the configuration and exit
  std::optional<WhoOptions> who;  ///< with `check`: what would become of this request
  bool print = false;             ///< print `text` and exit
};

/// The options, or the exit status when help, version, keys or an error has been printed already.
std::variant<Options, int> parse_command_line(int argc, const char* const* argv,
                                              const std::string& version);

}  // namespace mbgate::app
