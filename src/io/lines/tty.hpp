// SPDX-License-Identifier: Apache-2.0
// Opens a serial line for exclusive use with all its settings, or says why not. These calls may
// block for seconds on a dying adapter: they belong on a thread that may wait.
#pragma once

#include <string>
#include <vector>

#include "bus/settings.hpp"
#include "io/unique_fd.hpp"
#include "modbus/result.hpp"

namespace mbgate::io {

struct OpenTty {
  UniqueFd fd;  ///< non-blocking
  bus::LineKind kind;
  std::vector<std::string> warnings;
};

/// The path is looked up anew at each call: below /dev/serial/by-id it leads to another device
/// after each plugging. The error is one line with the path, what was asked and what the system
/// said.
Result<OpenTty, std::string> open_tty(const bus::LineSettings& line);

/// What to say when open() of `device` failed with `error`: what the system said and what helps.
std::string open_failure(const std::string& device, int error);

/// Gives the line back. What was not transmitted yet is thrown away: waiting for it can take 30 s.
/// A transceiver that we switch by RTS is left receiving, because a raised RTS would outlive us and
/// block the bus.
void close_tty(UniqueFd fd, const bus::LineSettings& line);

}  // namespace mbgate::io
