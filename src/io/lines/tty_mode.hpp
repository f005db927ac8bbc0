// SPDX-License-Identifier: Apache-2.0
// Baud rate and character format of a serial line, set through termios2 so that any rate can be
// asked for, and read back: drivers replace what they cannot do without a word.
#pragma once

#include <string>
#include <vector>

#include "bus/settings.hpp"
#include "modbus/result.hpp"

namespace mbgate::io {

/// May the driver's rate stand for the one asked for? At most 2 % off (Serial Line V1.02, 2.5.1:
/// the receiver's share of the tolerance).
bool is_close_enough(modbus::Baud asked, modbus::Baud got);

/// "19200 8E1"
std::string to_text(const bus::LineSettings& line);

/// Raw mode without flow control at the rate and format of `line`. Warnings, or why the line cannot
/// be used. A pseudo-terminal has no parity and no 7-bit characters: there, losing them is only a
/// warning.
Result<std::vector<std::string>, std::string> set_tty_mode(int fd, const bus::LineSettings& line,
                                                           bool is_pseudo_terminal);

}  // namespace mbgate::io
