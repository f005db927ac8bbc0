// SPDX-License-Identifier: Apache-2.0
#include "ctl/serial/serial_port.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <system_error>
#include <utility>

namespace mbgate::ctl {
namespace {

/// The device numbers of Unix 98 pseudo-terminals (Linux, Documentation/admin-guide/devices.txt).
constexpr unsigned kFirstPty = 136;
constexpr unsigned kLastPty = 143;

bool is_pty(int fd) {
  struct stat status {};
  return ::fstat(fd, &status) == 0 && major(status.st_rdev) >= kFirstPty &&
         major(status.st_rdev) <= kLastPty;
}

std::string held_text(const std::string& device) {
  return "a gateway or another program holds " + device +
         ": stop it first (systemctl stop mbgated), or scan through it with --host and --port";
}

/// Both locks of mbgated: TIOCEXCL does not stop root, and flock stops only those who ask.
std::optional<std::string> lock(int fd, const std::string& device, bool pseudo_terminal) {
  if (::flock(fd, LOCK_EX | LOCK_NB) != 0) {
    return errno == EWOULDBLOCK
               ? held_text(device)
               : device + ": cannot lock it: " + std::generic_category().message(errno);
  }
  // A pseudo-terminal keeps the flag of a program that has died, as long as its other end is open.
  int exclusive = 0;
  if (!pseudo_terminal && ::ioctl(fd, TIOCGEXCL, &exclusive) == 0 && exclusive != 0) {
    return held_text(device);
  }
  if (::ioctl(fd, TIOCEXCL) != 0) {
    return device + ": cannot take it for our use alone: " + std::generic_category().message(errno);
  }
  return std::nullopt;
}

}  // namespace

SerialPort::SerialPort(int fd) : fd_(fd), pseudo_terminal_(is_pty(fd)) {}

SerialPort::SerialPort(SerialPort&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)),
      pseudo_terminal_(other.pseudo_terminal_),
      before_(std::move(other.before_)) {}

SerialPort::~SerialPort() {
  if (fd_ >= 0) {
    if (before_) {
      discard_serial(fd_);  // else close() waits for what a failing adapter never sends
      restore_serial_settings(fd_, *before_);
    }
    ::ioctl(fd_, TIOCNXCL);
    ::close(fd_);
  }
}

Result<SerialPort, std::string> SerialPort::open(const std::string& device) {
  const int fd = ::open(device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    return port_failure(device, errno, serial_names());
  }
  std::optional<std::string> error;
  if (::isatty(fd) == 0) {
    error = device + ": this is no serial port";
  } else {
    error = lock(fd, device, is_pty(fd));
  }
  if (error) {
    ::close(fd);  // not by a SerialPort: another program's lock and bytes are not ours to drop
    return *std::move(error);
  }
  return SerialPort(fd);
}

std::optional<std::string> SerialPort::set_mode(const LineMode& mode) {
  if (!before_) {
    before_ = read_serial_settings(fd_);
  }
  return set_serial_mode(fd_, mode, pseudo_terminal_);
}

std::string port_failure(const std::string& device, int error,
                         const std::vector<std::string>& names) {
  switch (error) {
    case EBUSY: return held_text(device);
    case EACCES:
      return "you may not open " + device +
             ": your user must be in the group dialout (sudo adduser NAME dialout, then log in "
             "again)";
    case ENOENT:
    case ENODEV:
    case ENXIO: {
      std::string text = "there is no serial port " + device;
      for (const auto& name : names) {
        text.append(&name == &names.front() ? "; there is " : ", ").append(name);
      }
      return text;
    }
    default: return "cannot open " + device + ": " + std::generic_category().message(error);
  }
}

bool is_held(const std::string& device, const std::string& error) {
  return error == held_text(device);
}

std::vector<std::string> serial_names(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (std::filesystem::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error)) {
    names.push_back(entry->path().string());
  }
  std::ranges::sort(names);
  return names;
}

std::optional<std::string> lasting_name(const std::string& device,
                                        const std::vector<std::string>& names) {
  // Not by equivalent(), which does not compare devices.
  std::error_code error;
  const auto port = std::filesystem::canonical(device, error);
  const auto leads_there = [&](const std::string& name) {
    std::error_code broken;
    const auto end = std::filesystem::canonical(name, broken);
    return !error && !broken && end == port;
  };
  if (std::ranges::find(names, device) != names.end()) {
    return std::nullopt;
  }
  const auto found = std::ranges::find_if(names, leads_there);
  return found == names.end() ? std::nullopt : std::optional(*found);
}

}  // namespace mbgate::ctl
