// SPDX-License-Identifier: Apache-2.0
// <asm/termbits.h> declares termios2 and conflicts with <termios.h>: this file stands alone.
#include "ctl/serial/serial_mode.hpp"

#include <asm/termbits.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <cstring>
#include <system_error>

namespace mbgate::ctl {
namespace {

constexpr tcflag_t kFormatFlags = CSIZE | PARENB | PARODD | CSTOPB;

tcflag_t flags_of(const modbus::CharacterFormat& format) {
  tcflag_t flags = CS8;
  flags |= format.stop_bits == 2 ? CSTOPB : 0;
  switch (format.parity) {
    case modbus::Parity::none: break;
    case modbus::Parity::even: flags |= PARENB; break;
    case modbus::Parity::odd: flags |= PARENB | PARODD; break;
  }
  return flags;
}

termios2 raw(termios2 settings, const LineMode& mode) {
  // With INPCK a character of the wrong parity reads as 0, and the CRC fails: a drive that does not
  // look at the parity of the request must not pass for one that has it.
  settings.c_iflag = mode.format.parity == modbus::Parity::none ? 0 : INPCK;
  settings.c_oflag = 0;
  settings.c_lflag = 0;
  settings.c_cflag = CREAD | CLOCAL | BOTHER | flags_of(mode.format);
  settings.c_ispeed = static_cast<speed_t>(mode.baud);
  settings.c_ospeed = static_cast<speed_t>(mode.baud);
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  return settings;
}

std::string system_text() { return std::generic_category().message(errno); }

}  // namespace

std::optional<std::string> set_serial_mode(int fd, const LineMode& mode, bool pseudo_terminal) {
  termios2 present{};
  if (::ioctl(fd, TCGETS2, &present) != 0) {
    return "cannot read its settings: " + system_text();
  }
  const termios2 wanted = raw(present, mode);
  if (::ioctl(fd, TCSETS2, &wanted) != 0) {
    return "the driver refuses it: " + system_text();
  }
  termios2 real{};
  if (::ioctl(fd, TCGETS2, &real) != 0) {
    return "cannot read it back: " + system_text();
  }
  // The receiver's share of the tolerance is 2 % (Serial Line V1.02, 2.5.1).
  const std::uint64_t asked = wanted.c_ospeed;
  const std::uint64_t got = real.c_ospeed;
  if ((asked > got ? asked - got : got - asked) * 50 > asked) {
    return "the driver took " + std::to_string(got) + " baud instead";
  }
  const bool same = (real.c_cflag & kFormatFlags) == (wanted.c_cflag & kFormatFlags);
  if (!same && !pseudo_terminal) {
    return "the driver took another parity, or other stop bits, instead";
  }
  discard_serial(fd);
  return std::nullopt;
}

SerialSettings read_serial_settings(int fd) {
  termios2 present{};
  if (::ioctl(fd, TCGETS2, &present) != 0) {
    return {};
  }
  SerialSettings settings(sizeof present);
  std::memcpy(settings.data(), &present, sizeof present);
  return settings;
}

void restore_serial_settings(int fd, const SerialSettings& settings) {
  termios2 before{};
  if (settings.size() == sizeof before) {
    std::memcpy(&before, settings.data(), sizeof before);
    ::ioctl(fd, TCSETS2, &before);
  }
}

void discard_serial(int fd) { ::ioctl(fd, TCFLSH, TCIOFLUSH); }

}  // namespace mbgate::ctl
