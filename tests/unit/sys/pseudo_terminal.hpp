// SPDX-License-Identifier: Apache-2.0
// A pseudo-terminal for tests: the side of the devices, and the path of the line.
#pragma once

#include <fcntl.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <array>
#include <cstdint>
#include <span>
#include <string>

#include "sys/unique_fd.hpp"

namespace mbgate::sys {

class PseudoTerminal {
 public:
  PseudoTerminal() : device_side_(::posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC)) {
    std::array<char, 64> name{};
    if (device_side_.is_open() && ::grantpt(device_side_.get()) == 0 &&
        ::unlockpt(device_side_.get()) == 0 &&
        ::ptsname_r(device_side_.get(), name.data(), name.size()) == 0) {
      path_ = name.data();
    }
  }

  /// Empty if the system has no pseudo-terminals.
  [[nodiscard]] const std::string& path() const { return path_; }
  /// False if the line does not take all of it.
  [[nodiscard]] bool write(std::span<const std::uint8_t> bytes) const {
    return ::write(device_side_.get(), bytes.data(), bytes.size()) ==
           static_cast<ssize_t>(bytes.size());
  }
  /// What was written to the line; empty if nothing is there.
  [[nodiscard]] std::string read() const {
    std::array<char, 512> buffer{};
    const ssize_t count = ::read(device_side_.get(), buffer.data(), buffer.size());
    return count > 0 ? std::string(buffer.data(), static_cast<std::size_t>(count)) : std::string();
  }
  /// Bytes that can be read at once.
  [[nodiscard]] std::size_t waiting() const {
    int count = 0;
    ::ioctl(device_side_.get(), FIONREAD, &count);
    return static_cast<std::size_t>(count);
  }
  /// The adapter is pulled out.
  void unplug() { device_side_.reset(); }

 private:
  UniqueFd device_side_;
  std::string path_;
};

}  // namespace mbgate::sys
