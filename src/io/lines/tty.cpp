// SPDX-License-Identifier: Apache-2.0
#include "io/lines/tty.hpp"

#include <linux/serial.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <filesystem>
#include <fmt/format.h>
#include <optional>
#include <string_view>
#include <system_error>
#include <utility>

#include "io/lines/tty_direction.hpp"
#include "sys/tty.hpp"

namespace mbgate::io {
namespace {

/// The driver's name as DeviceAllow= of systemd wants it: that of the device without its number,
/// and not that of a link to it. ProcSubset=pid hides /proc/devices, where it stands.
std::string driver_name(const std::string& device) {
  std::error_code ignored;
  const auto real = std::filesystem::canonical(device, ignored);
  std::string name = (ignored ? std::filesystem::path(device) : real).filename().string();
  name.erase(name.find_last_not_of("0123456789") + 1);
  return name;
}

sys::TtyMode mode_of(const bus::LineSettings& line) {
  const auto parity = line.format.parity == modbus::Parity::none   ? sys::TtyParity::none
                      : line.format.parity == modbus::Parity::even ? sys::TtyParity::even
                                                                   : sys::TtyParity::odd;
  return {static_cast<std::uint32_t>(line.baud), line.format.data_bits, parity,
          line.format.stop_bits};
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
  return fmt::format("{}: no low-latency mode: {}", device, std::generic_category().message(errno));
}

/// What the kernel calls the device: "ttyUSB0"; nothing for what sysfs does not know.
std::string kernel_name(int fd) {
  struct stat status {};
  if (::fstat(fd, &status) != 0) {
    return {};
  }
  const auto link =
      fmt::format("/sys/dev/char/{}:{}", major(status.st_rdev), minor(status.st_rdev));
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
  return !sys::is_pseudo_terminal(fd) && !name.empty() && ::ioctl(fd, TIOCGSERIAL, &serial) == 0
             ? bus::LineKind::uart
             : bus::LineKind::virtual_line;
}

}  // namespace

std::string open_failure(const std::string& device, int error) {
  std::string text =
      fmt::format("cannot open {}: {}", device, std::generic_category().message(error));
  switch (error) {
    case EBUSY: return device + ": another program uses it";
    case ENOTTY: return device + ": this is not a serial line";
    case EACCES:
      return fmt::format(
          "{}; the user that mbgated runs as must be in the group of this port, mostly dialout "
          "(\"ls -lL {}\" names it), and its mode must let that group read and write",
          text, device);
    case EPERM:
      // The device cgroup refuses with EPERM where file modes refuse with EACCES. A DeviceAllow= of
      // a driver that was not loaded when the unit started allows nothing.
      return fmt::format(
          "{}; if systemd started mbgated, its unit does not allow this driver, or the driver was "
          "loaded after the unit had started: the unit needs \"DeviceAllow=char-{} rw\" (systemctl "
          "edit mbgated)",
          text, driver_name(device));
    default: return text;
  }
}

Result<std::vector<std::string>, std::string> set_mode(int fd, const bus::LineSettings& line,
                                                       bool is_pseudo_terminal) {
  const sys::TtyMode wanted = mode_of(line);
  const auto real = sys::set_tty_mode(fd, wanted);
  if (!real) {
    return fmt::format("{}: cannot set {}: {}", line.device, to_text(line),
                       std::generic_category().message(errno));
  }
  if (!real->has_rate_near(wanted.baud)) {
    return fmt::format("{}: asked for {} baud, the driver took {} baud, which is more than 2 % off",
                       line.device, wanted.baud, real->baud);
  }
  if (real->has_format_of(wanted)) {
    return std::vector<std::string>();
  }
  std::string text = fmt::format("{}: asked for {}, the driver took {}", line.device,
                                 wanted.format_text(), real->format_text());
  if (!is_pseudo_terminal) {
    return text;
  }
  return std::vector{std::move(text)};
}

std::string to_text(const bus::LineSettings& line) {
  return fmt::format("{} {}", fmt::underlying(line.baud), mode_of(line).format_text());
}

Result<OpenTty, std::string> open_tty(const bus::LineSettings& line) {
  sys::UniqueFd fd = sys::open_tty(line.device);
  if (!fd.is_open()) {
    return open_failure(line.device, errno);
  }
  auto warnings = set_mode(fd.get(), line, sys::is_pseudo_terminal(fd.get()));
  auto error = warnings ? set_direction_control(fd.get(), line)
                        : std::optional<std::string>(warnings.error());
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
  sys::discard_all(fd.get());
  const bus::LineKind kind = kind_of(fd.get());
  return OpenTty{std::move(fd), kind, *std::move(warnings)};
}

void close_tty(sys::UniqueFd fd, const bus::LineSettings& line) {
  if (!fd.is_open()) {
    return;
  }
  sys::discard_output(fd.get());
  if (line.rs485 == bus::Rs485::rts) {
    set_rts(fd.get(), false);
  }
  sys::release_tty(fd.get());
}

}  // namespace mbgate::io
