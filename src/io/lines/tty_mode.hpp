// SPDX-License-Identifier: Apache-2.0
// Baud rate and character format of a serial line. They are set through termios2, so that any rate
// is possible, and read back: drivers silently replace what they cannot do.
#pragma once

#include <string>
#include <vector>

#include "bus/settings.hpp"
#include "modbus/result.hpp"

namespace mbgate::io {

/// Is the driver's rate close enough to the one asked for? At most 2 % off (Serial Line V1.02,
/// 2.5.1: the receiver's share of the tolerance).
bool is_close_enough(modbus::Baud asked, modbus::Baud got);

/// "19200 8E1"
std::string to_text(const bus::LineSettings& line);

/// Sets raw mode without flow control, at the rate and format of `line`. Returns warnings, or the
/// error why the line cannot be used. A pseudo-terminal has neither parity nor 7-bit characters;
/// there this is only a warning.
Result<std::vector<std::string>, std::string> set_tty_mode(int fd, const bus::LineSettings& line,
                                                           bool is_pseudo_terminal);

}  // namespace mbgate::io
