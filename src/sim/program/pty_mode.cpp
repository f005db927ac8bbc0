// SPDX-License-Identifier: Apache-2.0
// <asm/termbits.h> declares termios2 and conflicts with <termios.h>, so this file stands alone.
#include "sim/program/pty_mode.hpp"

#include <asm/termbits.h>
#include <sys/ioctl.h>

namespace mbgate::sim {

bool make_raw(int port, PtySpeed speed) {
  termios2 mode{};
  if (::ioctl(port, TCGETS2, &mode) != 0) {
    return false;
  }
  mode.c_iflag = 0;
  mode.c_oflag = 0;
  mode.c_lflag = 0;
  mode.c_cflag = CREAD | CLOCAL | CS8 | BOTHER;
  mode.c_cflag |= speed.stop_bits == 2 ? CSTOPB : 0;
  mode.c_ispeed = static_cast<speed_t>(speed.baud);
  mode.c_ospeed = static_cast<speed_t>(speed.baud);
  mode.c_cc[VMIN] = 1;
  mode.c_cc[VTIME] = 0;
  return ::ioctl(port, TCSETS2, &mode) == 0;
}

std::optional<PtySpeed> speed_of(int port) {
  termios2 mode{};
  if (::ioctl(port, TCGETS2, &mode) != 0) {
    return std::nullopt;
  }
  return PtySpeed{modbus::Baud{mode.c_ospeed}, (mode.c_cflag & CSTOPB) != 0 ? 2U : 1U};
}

}  // namespace mbgate::sim
