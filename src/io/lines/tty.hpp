// SPDX-License-Identifier: Apache-2.0
// Opens a serial line for exclusive use with all its settings, or says why not. These calls may
// block for seconds on a failing adapter: call them on a thread that may wait.
#pragma once

#include <string>
#include <vector>

#include "bus/settings.hpp"
#include "modbus/result.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::io {

struct OpenTty {
  sys::UniqueFd fd;  ///< non-blocking
  bus::LineKind kind;
  std::vector<std::string> warnings;
};

/// The path is resolved at each call: a link below /dev/serial/by-id leads to another device each
/// time that the adapter is plugged in. The error is one line with the path, what was tried, and
/// what the system said.
Result<OpenTty, std::string> open_tty(const bus::LineSettings& line);

/// The text when open() of `device` has failed with `error`: what the system said, and what helps.
std::string open_failure(const std::string& device, int error);

/// "19200 8E1"
std::string to_text(const bus::LineSettings& line);

/// Sets rate and format. Returns warnings, or the error why the line cannot be used. A
/// pseudo-terminal has neither parity nor 7-bit characters; there this is only a warning.
Result<std::vector<std::string>, std::string> set_mode(int fd, const bus::LineSettings& line,
                                                       bool is_pseudo_terminal);

/// Closes the line. What was not transmitted yet is discarded, because waiting for it can take 30
/// s. A transceiver that we switch by RTS is left receiving: a raised RTS would stay after us and
/// block the bus.
void close_tty(sys::UniqueFd fd, const bus::LineSettings& line);

}  // namespace mbgate::io
