// SPDX-License-Identifier: Apache-2.0
// The serial ports that are being closed, which may take long. A bus that opens one of them waits
// until the port is free.
#pragma once

#include <array>
#include <chrono>
#include <future>
#include <map>
#include <string>

namespace mbgate::io {

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
  /// `closed` is ready once the port is given back.
  void note(const std::string& device, const std::shared_future<void>& closed) {
    std::erase_if(closing_, [](const auto& port) {
      return port.second.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    });
    closing_[device] = closed;
  }
  /// Nothing to wait for: not valid.
  [[nodiscard]] std::shared_future<void> of(const std::string& device) const {
    const auto port = closing_.find(device);
    return port == closing_.end() ? std::shared_future<void>() : port->second;
  }

 private:
  std::map<std::string, std::shared_future<void>> closing_;
};

}  // namespace mbgate::io
