// SPDX-License-Identifier: Apache-2.0
// Sets the mode of a serial port, of any rate, and reads it back: drivers silently replace what
// they cannot do, and a sweep would take one rate for another.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "ctl/serial/line_mode.hpp"

namespace mbgate::ctl {

/// Raw, without flow control; what was received before is discarded. Returns why it cannot be done,
/// or nothing. A pseudo-terminal has no parity, and is not asked for what became of it.
std::optional<std::string> set_serial_mode(int fd, const LineMode& mode, bool pseudo_terminal);

/// All settings of a port, to be given back as they are; empty where they cannot be read.
using SerialSettings = std::vector<std::uint8_t>;
SerialSettings read_serial_settings(int fd);
/// Waits for nothing.
void restore_serial_settings(int fd, const SerialSettings& settings);

/// Discards what was received and not read, and what was not sent yet.
void discard_serial(int fd);

}  // namespace mbgate::ctl
