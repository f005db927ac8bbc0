// SPDX-License-Identifier: Apache-2.0
// Direction control of the RS-485 transceiver: the kernel switches it, or we do by RTS. The ioctl
// is passed in as a function, because no pseudo-terminal supports these requests and a test must be
// able to act as the driver.
#pragma once

#include <optional>
#include <string>

#include "bus/settings.hpp"

namespace mbgate::io {

/// ioctl(2).
using IoControl = int (*)(int fd, unsigned long request, void* argument);
int system_io_control(int fd, unsigned long request, void* argument);

/// Sets up the direction control that `line` asks for; RTS is left at receiving. Returns why it
/// cannot be done, or nothing.
std::optional<std::string> set_direction_control(int fd, const bus::LineSettings& line,
                                                 IoControl control = system_io_control);

/// Raises RTS (sending) or lowers it (receiving). False if the driver refuses.
bool set_rts(int fd, bool sending, IoControl control = system_io_control);

/// Has the last bit left the transmitter's shift register? Nothing if the driver cannot say.
std::optional<bool> is_transmitter_empty(int fd, IoControl control = system_io_control);

}  // namespace mbgate::io
