// SPDX-License-Identifier: Apache-2.0
#include "io/lines/tty.hpp"

#include <fcntl.h>
#include <linux/serial.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "io/lines/tty_direction.hpp"
#include "io/lines/tty_mode.hpp"

namespace mbgate::io {
namespace {

/// The device numbers of Unix 98 pseudo-terminals (Linux, Documentation/admin-guide/devices.txt).
constexpr unsigned kFirstPtyMajor = 136;
constexpr unsigned kLastPtyMajor = 143;

std::string in_use(const std::string& device) { return device + ": another program uses it"; }

/// The driver's name as DeviceAllow= of systemd wants it: that of the device without its number,
/// and not that of a link to it. ProcSubset=pid hides /proc/devices, where it stands.
std::string driver_name(const std::string& device) {
  std::error_code ignored;
  const auto real = std::filesystem::canonical(device, ignored);
  std::string name = (ignored ? std::filesystem::path(device) : real).filename().string();
  name.erase(name.find_last_not_of("0123456789") + 1);
  return name;
}

bool is_pseudo_terminal(int fd) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) {
    return false;
  }
  return major(status.st_rdev) >= kFirstPtyMajor && major(status.st_rdev) <= kLastPtyMajor;
}

std::optional<std::string> take_exclusively(int fd, const std::string& device,
                                            bool pseudo_terminal) {
  // TIOCEXCL does not stop root, and flock stops only those who ask: both together stop everyone
  // who looks.
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return errno == EWOULDBLOCK
               ? in_use(device)
               : device + ": cannot lock it: " + std::generic_category().message(errno);
  }
  // A pseudo-terminal keeps the flag of a program that has died, as long as its other end is open.
  int exclusive = 0;
  if (!pseudo_terminal && ::ioctl(fd, TIOCGEXCL, &exclusive) == 0 && exclusive != 0) {
    return in_use(device);
  }
  if (::ioctl(fd, TIOCEXCL) != 0) {
    return device + ": cannot take it for exclusive use: " + std::generic_category().message(errno);
  }
  return std::nullopt;
}

/// Without it an FTDI chip holds received bytes back for up to 16 ms. Only at open: changing it
/// under traffic can stall reception.
std::optional<std::string> ask_for_low_latency(int fd, const std::string& device) {
  serial_struct serial{};
  if (::ioctl(fd, TIOCGSERIAL, &serial) == 0) {
    serial.flags |= ASYNC_LOW_LATENCY;
    if (::ioctl(fd, TIOCSSERIAL, &serial) == 0) {
      return std::nullopt;
    }
  }
  // Pseudo-terminals and many adapters have no such thing and need none.
  if (errno == ENOTTY || errno == EINVAL || errno == EOPNOTSUPP) {
    return std::nullopt;
  }
  return device + ": no low-latency mode: " + std::generic_category().message(errno);
}

/// What the kernel calls the device: "ttyUSB0"; nothing for what sysfs does not know.
std::string kernel_name(int fd) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) {
    return {};
  }
  const auto link = "/sys/dev/char/" + std::to_string(major(status.st_rdev)) + ':' +
                    std::to_string(minor(status.st_rdev));
  std::error_code error;
  return std::filesystem::read_symlink(link, error).filename();
}

/// A UART has line parameters of its own, which TIOCGSERIAL gives. So has a CDC ACM device, but
/// what is behind it takes whole buffers at the pace of the bus that it hangs on.
bus::LineKind kind_of(int fd) {
  const std::string name = kernel_name(fd);
  constexpr std::array<std::string_view, 3> kUnpaced{"ttyACM", "rfcomm", "ttyGS"};
  if (std::ranges::any_of(kUnpaced, [&](auto start) { return name.starts_with(start); })) {
    return bus::LineKind::adapter;
  }
  serial_struct serial{};
  return !is_pseudo_terminal(fd) && !name.empty() && ::ioctl(fd, TIOCGSERIAL, &serial) == 0
             ? bus::LineKind::uart
             : bus::LineKind::virtual_line;
}

}  // namespace

std::string open_failure(const std::string& device, int error) {
  std::string text = "cannot open " + device + ": " + std::generic_category().message(error);
  switch (error) {
    case EBUSY: return in_use(device);
    case EACCES:
      return text +
             "; the user that mbgated runs as must be in the group of this port, mostly dialout "
             "(\"ls -lL " +
             device + "\" names it), and its mode must let that group read and write";
    case EPERM:
      // The device cgroup refuses with EPERM where file modes refuse with EACCES. A DeviceAllow= of
      // a driver that was not loaded when the unit started allows nothing.
      return text +
             "; if systemd started mbgated, its unit does not allow this driver, or the driver was "
             "loaded after the unit had started: the unit needs \"DeviceAllow=char-" +
             driver_name(device) + " rw\" (systemctl edit mbgated)";
    default: return text;
  }
}

Result<OpenTty, std::string> open_tty(const bus::LineSettings& line) {
  UniqueFd fd(::open(line.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  if (!fd.is_open()) {
    return open_failure(line.device, errno);
  }
  if (::isatty(fd.get()) == 0) {
    return line.device + ": this is no serial line";
  }
  const bool pseudo_terminal = is_pseudo_terminal(fd.get());
  if (auto error = take_exclusively(fd.get(), line.device, pseudo_terminal)) {
    return *std::move(error);
  }
  auto warnings = set_tty_mode(fd.get(), line, pseudo_terminal);
  std::optional<std::string> error;
  if (!warnings) {
    error = warnings.error();
  } else {
    error = set_direction_control(fd.get(), line);
  }
  if (error) {
    close_tty(std::move(fd), line);
    return *std::move(error);
  }
  if (line.low_latency) {
    if (auto warning = ask_for_low_latency(fd.get(), line.device)) {
      warnings->push_back(*std::move(warning));
    }
  }
  // What lies there was meant for somebody before us.
  ::tcflush(fd.get(), TCIOFLUSH);
  const bus::LineKind kind = kind_of(fd.get());
  return OpenTty{std::move(fd), kind, *std::move(warnings)};
}

std::size_t bytes_to_read(int fd) {
  int count = 0;
  return ::ioctl(fd, FIONREAD, &count) == 0 && count > 0 ? static_cast<std::size_t>(count) : 0;
}

std::size_t bytes_to_send(int fd) {
  int count = 0;
  return ::ioctl(fd, TIOCOUTQ, &count) == 0 && count > 0 ? static_cast<std::size_t>(count) : 0;
}

void close_tty(UniqueFd fd, const bus::LineSettings& line) {
  if (!fd.is_open()) {
    return;
  }
  ::tcflush(fd.get(), TCOFLUSH);
  if (line.rs485 == bus::Rs485::rts) {
    set_rts(fd.get(), false);
  }
  ::ioctl(fd.get(), TIOCNXCL);
}

}  // namespace mbgate::io
