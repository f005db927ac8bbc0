// SPDX-License-Identifier: Apache-2.0
// The serial ports and servers that lines have open, by device number and by address. It keeps two
// buses from using the same one under different names: each would disturb the transactions of the
// other.
#pragma once

#include <sys/stat.h>

#include <array>
#include <chrono>
#include <fmt/core.h>
#include <future>
#include <map>
#include <optional>
#include <string>
#include <utility>

namespace mbgate::io {

class OpenEnds {
 public:
  /// `holder`: the line that has it open, of the bus of this name.
  void note(const void* holder, std::string end, std::string bus) {
    open_[holder] = {std::move(end), std::move(bus)};
  }
  void forget(const void* holder) { open_.erase(holder); }
  /// The bus whose line has it open, if that is another one.
  [[nodiscard]] std::optional<std::string> other(const void* asker, const std::string& end) const {
    for (const auto& [holder, open] : open_) {
      if (holder != asker && open.end == end) {
        return open.bus;
      }
    }
    return std::nullopt;
  }

 private:
  struct Open {
    std::string end;
    std::string bus;
  };
  std::map<const void*, Open> open_;
};

/// The port behind a path; links lead to the same one.
inline std::string port_end(const std::string& device) {
  struct stat status {};
  return ::stat(device.c_str(), &status) == 0 && S_ISCHR(status.st_mode)
             ? fmt::format("port {}", status.st_rdev)
             : device;
}

// The serial ports that are being closed, which may take long. A bus that opens one of them waits
// until the port is free.

/// What the opening of a port waits for: that the port which its line had before is given back,
/// which may be the same by another path, and the one that is to be opened.
using Closings = std::array<std::shared_future<void>, 2>;

/// Waits for them, but not for ever: a dying adapter holds close() for long.
inline void wait_for(const Closings& closings, std::chrono::seconds limit) {
  for (const std::shared_future<void>& closed : closings) {
    if (closed.valid()) {
      closed.wait_for(limit);
    }
  }
}

class ClosingPorts {
 public:
  /// `device`: by any of its paths. `closed` is ready once the port is given back.
  void note(const std::string& device, const std::shared_future<void>& closed) {
    std::erase_if(closing_, [](const auto& port) {
      return port.second.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    });
    closing_[port_end(device)] = closed;
  }
  /// Waits until all are given back, at most for so long.
  void wait_for_all(std::chrono::milliseconds limit) const {
    const auto until = std::chrono::steady_clock::now() + limit;
    for (const auto& [port, closed] : closing_) {
      closed.wait_until(until);
    }
  }
  /// Nothing to wait for: not valid.
  [[nodiscard]] std::shared_future<void> of(const std::string& device) const {
    const auto port = closing_.find(port_end(device));
    return port == closing_.end() ? std::shared_future<void>() : port->second;
  }

 private:
  std::map<std::string, std::shared_future<void>> closing_;
};

}  // namespace mbgate::io
