// SPDX-License-Identifier: Apache-2.0
// <asm/termbits.h> declares termios2 and conflicts with <termios.h>: this file may include nothing
// that includes that.
#include "sys/tty.hpp"

#include <asm/termbits.h>
#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <cerrno>
#include <cstring>

namespace mbgate::sys {
namespace {

/// The device numbers of Unix 98 pseudo-terminals (Linux, Documentation/admin-guide/devices.txt).
constexpr unsigned kFirstPtyMajor = 136;
constexpr unsigned kLastPtyMajor = 143;

tcflag_t format_flags(const TtyMode& mode) {
  tcflag_t flags = mode.data_bits == 7 ? CS7 : CS8;
  flags |= mode.stop_bits == 2 ? CSTOPB : 0;
  switch (mode.parity) {
    case TtyParity::none: break;
    case TtyParity::even: flags |= PARENB; break;
    case TtyParity::odd: flags |= PARENB | PARODD; break;
  }
  return flags;
}

/// 0, or an errno.
int take_exclusively(int fd) {
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return errno == EWOULDBLOCK ? EBUSY : errno;
  }
  // A pseudo-terminal keeps the flag of a program that has died, as long as its other end is open.
  int exclusive = 0;
  if (!is_pseudo_terminal(fd) && ::ioctl(fd, TIOCGEXCL, &exclusive) == 0 && exclusive != 0) {
    return EBUSY;
  }
  return ::ioctl(fd, TIOCEXCL) == 0 ? 0 : errno;
}

std::size_t count_of(int fd, unsigned long request) {
  int count = 0;
  return ::ioctl(fd, request, &count) == 0 && count > 0 ? static_cast<std::size_t>(count) : 0;
}

}  // namespace

std::string TtyMode::format_text() const {
  const char letter = parity == TtyParity::none ? 'N' : parity == TtyParity::even ? 'E' : 'O';
  return std::to_string(data_bits) + letter + std::to_string(stop_bits);
}

bool TtyMode::has_rate_near(std::uint32_t asked) const {
  const std::uint64_t distance = asked > baud ? asked - baud : baud - asked;
  return distance * 50 <= asked;
}

UniqueFd open_tty(const std::string& device) {
  UniqueFd fd(::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (fd.is_open()) {
    const int error = ::isatty(fd.get()) == 0 ? ENOTTY : take_exclusively(fd.get());
    if (error != 0) {
      fd.reset();
      errno = error;
    }
  }
  return fd;
}

void release_tty(int fd) { ::ioctl(fd, TIOCNXCL); }

bool is_pseudo_terminal(int fd) {
  struct stat status {};
  return ::fstat(fd, &status) == 0 && major(status.st_rdev) >= kFirstPtyMajor &&
         major(status.st_rdev) <= kLastPtyMajor;
}

std::optional<TtyMode> set_tty_mode(int fd, const TtyMode& mode) {
  termios2 settings{};
  if (::ioctl(fd, TCGETS2, &settings) != 0) {
    return std::nullopt;
  }
  settings.c_iflag = mode.checks_parity && mode.parity != TtyParity::none ? INPCK : 0;
  settings.c_oflag = 0;
  settings.c_lflag = 0;
  // BOTHER: the rate is the number in c_ospeed, not one of the classic constants. Nothing in the
  // bits of the input rate means that it is the same.
  settings.c_cflag = CREAD | CLOCAL | BOTHER | format_flags(mode);
  settings.c_ispeed = mode.baud;
  settings.c_ospeed = mode.baud;
  // With VMIN = 0 an empty line reads as 0 bytes, which means the end of the stream to Asio.
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
  return ::ioctl(fd, TCSETS2, &settings) == 0 ? tty_mode(fd) : std::nullopt;
}

std::optional<TtyMode> tty_mode(int fd) {
  termios2 settings{};
  if (::ioctl(fd, TCGETS2, &settings) != 0) {
    return std::nullopt;
  }
  const tcflag_t flags = settings.c_cflag;
  TtyMode mode;
  mode.baud = settings.c_ospeed;
  mode.data_bits = (flags & CSIZE) == CS7 ? 7 : 8;
  mode.stop_bits = (flags & CSTOPB) != 0 ? 2 : 1;
  if ((flags & PARENB) != 0) {
    mode.parity = (flags & PARODD) != 0 ? TtyParity::odd : TtyParity::even;
  }
  return mode;
}

TtySettings read_tty_settings(int fd) {
  termios2 present{};
  if (::ioctl(fd, TCGETS2, &present) != 0) {
    return {};
  }
  TtySettings settings(sizeof present);
  std::memcpy(settings.data(), &present, sizeof present);
  return settings;
}

void restore_tty_settings(int fd, const TtySettings& settings) {
  termios2 before{};
  if (settings.size() == sizeof before) {
    std::memcpy(&before, settings.data(), sizeof before);
    ::ioctl(fd, TCSETS2, &before);
  }
}

void discard_output(int fd) { ::ioctl(fd, TCFLSH, TCOFLUSH); }
void discard_all(int fd) { ::ioctl(fd, TCFLSH, TCIOFLUSH); }

std::size_t bytes_to_read(int fd) { return count_of(fd, FIONREAD); }
std::size_t bytes_to_send(int fd) { return count_of(fd, TIOCOUTQ); }

}  // namespace mbgate::sys
