// SPDX-License-Identifier: Apache-2.0
// <asm/termbits.h> declares termios2 and conflicts with <termios.h>, which Asio includes: this file
// may include neither of them.
#include "io/lines/tty_mode.hpp"

#include <asm/termbits.h>
#include <sys/ioctl.h>

#include <cerrno>
#include <system_error>

namespace mbgate::io {
namespace {

/// The flags of c_cflag that are asked for and must be found again.
constexpr tcflag_t kFormatFlags = CSIZE | PARENB | PARODD | CSTOPB;

tcflag_t format_flags(const modbus::CharacterFormat& format) {
  tcflag_t flags = format.data_bits == 7 ? CS7 : CS8;
  if (format.stop_bits == 2) {
    flags |= CSTOPB;
  }
  switch (format.parity) {
    case modbus::Parity::none: break;
    case modbus::Parity::even: flags |= PARENB; break;
    case modbus::Parity::odd: flags |= PARENB | PARODD; break;
  }
  return flags;
}

std::string format_text(tcflag_t flags) {
  std::string text = (flags & CSIZE) == CS7 ? "7" : "8";
  if ((flags & PARENB) == 0) {
    text += 'N';
  } else {
    text += (flags & PARODD) != 0 ? 'O' : 'E';
  }
  text += (flags & CSTOPB) != 0 ? '2' : '1';
  return text;
}

termios2 raw_mode(termios2 mode, const bus::LineSettings& line) {
  mode.c_iflag = 0;
  mode.c_oflag = 0;
  mode.c_lflag = 0;
  // BOTHER: the rate is the number in c_ospeed, not one of the classic constants. Nothing in the
  // bits of the input rate means that it is the same.
  mode.c_cflag = CREAD | CLOCAL | BOTHER | format_flags(line.format);
  mode.c_ispeed = static_cast<speed_t>(line.baud);
  mode.c_ospeed = static_cast<speed_t>(line.baud);
  // With VMIN = 0 an empty line reads as 0 bytes, which means the end of the stream to Asio.
  mode.c_cc[VMIN] = 1;
  mode.c_cc[VTIME] = 0;
  return mode;
}

std::string refusal(const bus::LineSettings& line, const char* step) {
  return line.device + ": cannot " + step + " " + to_text(line) + ": " +
         std::generic_category().message(errno);
}

}  // namespace

bool is_close_enough(modbus::Baud asked, modbus::Baud got) {
  const auto wanted = static_cast<std::uint64_t>(asked);
  const auto real = static_cast<std::uint64_t>(got);
  const std::uint64_t distance = wanted > real ? wanted - real : real - wanted;
  return distance * 50 <= wanted;
}

std::string to_text(const bus::LineSettings& line) {
  return std::to_string(static_cast<std::uint32_t>(line.baud)) + " " +
         format_text(format_flags(line.format));
}

Result<std::vector<std::string>, std::string> set_tty_mode(int fd, const bus::LineSettings& line,
                                                           bool is_pseudo_terminal) {
  termios2 mode{};
  if (::ioctl(fd, TCGETS2, &mode) != 0) {
    return refusal(line, "read the settings before setting");
  }
  const termios2 wanted = raw_mode(mode, line);
  if (::ioctl(fd, TCSETS2, &wanted) != 0) {
    return refusal(line, "set");
  }
  termios2 real{};
  if (::ioctl(fd, TCGETS2, &real) != 0) {
    return refusal(line, "read back");
  }
  if (!is_close_enough(line.baud, modbus::Baud{real.c_ospeed})) {
    return line.device + ": asked for " + std::to_string(wanted.c_ospeed) +
           " baud, the driver took " + std::to_string(real.c_ospeed) +
           " baud, which is more than 2 % off";
  }
  std::vector<std::string> warnings;
  if ((real.c_cflag & kFormatFlags) != (wanted.c_cflag & kFormatFlags)) {
    std::string text = line.device + ": asked for " + format_text(wanted.c_cflag) +
                       ", the driver took " + format_text(real.c_cflag);
    if (!is_pseudo_terminal) {
      return text;
    }
    warnings.push_back(std::move(text));
  }
  return warnings;
}

}  // namespace mbgate::io
