// SPDX-License-Identifier: Apache-2.0
// The command line of mbgated.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "app/who/who_options.hpp"
#include "modbus/result.hpp"
#include "routing/client_address.hpp"

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

// A transparent gateway of one line without a configuration file: the options that describe it, and
// the configuration that they stand for. Its text is loaded as that of a file is, so what is
// checked there is not checked here.

using routing::ListenAddress;

/// The defaults are those of the configuration.
struct SerialOptions {
  std::string device;
  std::int64_t baud = 19200;
  std::string parity = "even";
  std::int64_t stop_bits = 1;
  ListenAddress listen{};            ///< where clients connect
  std::vector<std::string> allow{};  ///< who may connect: addresses or blocks; empty: everyone
};

/// "127.0.0.1:1502" or "[::1]:1502". The error says what is wrong. That is so too where other
/// machines reach the address and `allow` is empty: drives are not opened to a network by chance.
Result<ListenAddress, std::string> parse_listen(std::string_view text,
                                                const std::vector<std::string>& allow);

/// The text of the configuration: one bus, and a transparent listener of it.
std::string serial_config(const SerialOptions& options);

}  // namespace mbgate::app
