// SPDX-License-Identifier: Apache-2.0
// Parses the command line of mbgatectl: "mbgatectl read holding 0x1E --type i32 --unit 1".
#pragma once

#include <string>
#include <variant>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// Text to print instead of running a command: help or the version (status 0), or an error (status
/// 2).
struct Notice {
  int status;
  std::string text;
};

/// `version` is what --version prints.
std::variant<Command, Notice> parse_command_line(const std::string& version, int count,
                                                 const char* const* arguments);

}  // namespace mbgate::ctl
