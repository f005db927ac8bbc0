// SPDX-License-Identifier: Apache-2.0
// The options of a scan without a gateway: which serial port, and what is tried there.
#pragma once

#include <string>

#include "ctl/request/command.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming): the library is named so
class App;
}

namespace mbgate::ctl {

class PortOptions {
 public:
  PortOptions() = default;
  PortOptions(const PortOptions&) = delete;
  PortOptions& operator=(const PortOptions&) = delete;

  /// `command` has the options of a server, which are not for a port, and keeps references to this
  /// object.
  void add_to(CLI::App& command);
  [[nodiscard]] bool given() const { return !device_.empty(); }
  /// The error is a full sentence.
  [[nodiscard]] Result<PortSweep, std::string> port() const;

 private:
  std::string device_;
  // 9600 first: the most frequent setting of drives as they are delivered.
  std::string bauds_ = "9600,19200,115200,38400,57600";
  std::string parities_ = "even,none,odd";
  std::string stop_bits_ = "1";
  std::string wait_ = "100ms";
  bool all_modes_ = false;
};

}  // namespace mbgate::ctl
