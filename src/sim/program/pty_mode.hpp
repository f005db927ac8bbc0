// SPDX-License-Identifier: Apache-2.0
// How a pty is set as a serial port: any baud rate, not only the classic ones. Linux keeps neither
// parity nor data bits of a pty. Part of the simulator's shell.
#pragma once

#include <optional>

#include "modbus/rtu_timing.hpp"

namespace mbgate::sim {

struct PtySpeed {
  modbus::Baud baud{115200};
  unsigned stop_bits = 1;
};

/// Bytes pass as they are. False if the system refuses.
bool make_raw(int port, PtySpeed speed);

std::optional<PtySpeed> speed_of(int port);

}  // namespace mbgate::sim
