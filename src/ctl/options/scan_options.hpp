// SPDX-License-Identifier: Apache-2.0
// What belongs to `mbgatectl scan` on the command line.
#pragma once

#include <string>

#include "ctl/options/port_options.hpp"
#include "ctl/options/server_options.hpp"
#include "ctl/request/command.hpp"

namespace mbgate::ctl {

class ScanOptions {
 public:
  explicit ScanOptions(CLI::App& app);
  ScanOptions(const ScanOptions&) = delete;
  ScanOptions& operator=(const ScanOptions&) = delete;

  [[nodiscard]] bool given() const;
  /// The error is a full sentence.
  [[nodiscard]] Result<Command, std::string> command() const;

 private:
  CLI::App* scan_;
  ServerOptions server_;
  PortOptions port_;
  ScanCommand words_;
  std::string units_ = "1-32";
};

}  // namespace mbgate::ctl
