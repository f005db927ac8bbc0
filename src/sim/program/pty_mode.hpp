// SPDX-License-Identifier: Apache-2.0
// The serial port settings of a pty: any baud rate, not only the standard ones. Linux keeps neither
// parity nor data bits of a pty. Part of the simulator's shell.
#pragma once

#include <optional>

#include "modbus/rtu_timing.hpp"

namespace mbgate::sim {

struct PtySpeed {
  modbus::Baud baud{115200};
  unsigned stop_bits = 1;
};

/// Raw mode: bytes pass unchanged. False if the system refuses.
bool make_raw(int port, PtySpeed speed);

std::optional<PtySpeed> speed_of(int port);

}  // namespace mbgate::sim
