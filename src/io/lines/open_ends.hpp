// SPDX-License-Identifier: Apache-2.0
// The serial ports and servers that lines have open, by device number and by address. It keeps two
// buses from using the same one under different names: each would disturb the transactions of the
// other.
#pragma once

#include <sys/stat.h>

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
             ? "port " + std::to_string(status.st_rdev)
             : device;
}

}  // namespace mbgate::io
