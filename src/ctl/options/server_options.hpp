// SPDX-License-Identifier: Apache-2.0
// The options that say which server is asked, and times as options have them.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>

#include "ctl/request/command.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming): the library is named so
class App;
}

namespace mbgate::ctl {

/// `text` as a time that is not shorter than `least`. The error is a full sentence.
Result<std::chrono::nanoseconds, std::string> parse_time(const std::string& text,
                                                         std::chrono::milliseconds least);

/// Which server a command asks, and whether over TLS.
class ServerOptions {
 public:
  ServerOptions() = default;
  ServerOptions(const ServerOptions&) = delete;
  ServerOptions& operator=(const ServerOptions&) = delete;

  /// `command` keeps references to this object.
  void add_to(CLI::App& command);
  /// What TLS needs, for commands that speak it.
  void add_tls_to(CLI::App& command);
  /// The server; its unit is not set. The error is a full sentence.
  [[nodiscard]] Result<Target, std::string> target() const;

 private:
  Target target_;
  std::string timeout_ = "5s";
  std::optional<std::uint16_t> port_;
  bool tls_ = false;
  TlsIdentity identity_;
};

}  // namespace mbgate::ctl
