// SPDX-License-Identifier: Apache-2.0
// Options that several subcommands have, and what their words mean. Wrong words throw WrongUsage.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>

#include "ctl/options/subcommands.hpp"

namespace mbgate::ctl {

/// The value, if there is one.
template <typename Value>
Value expect(const Result<Value, std::string>& result) {
  if (!result) {
    throw WrongUsage(result.error());
  }
  return *result;
}

/// `text` as a time that is not shorter than `least`.
std::chrono::nanoseconds parse_time(const std::string& text, std::chrono::milliseconds least);

/// Which server a command asks, and whether over TLS.
struct ServerWords {
  Target target;
  std::string timeout = "5s";
  std::optional<std::uint16_t> port;
  bool tls = false;
  TlsIdentity identity;
};

// `command` keeps references to what these write into.
void add_server(CLI::App& command, ServerWords& words);
void add_tls(CLI::App& command, ServerWords& words);
void add_profile_folder(CLI::App& command, std::optional<std::filesystem::path>& folder);
/// --control: where mbgated is asked.
void add_control(CLI::App& command, std::string& socket);

/// The server; its unit is not set.
Target target_of(const ServerWords& words);

}  // namespace mbgate::ctl
