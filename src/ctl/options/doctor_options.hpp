// SPDX-License-Identifier: Apache-2.0
// What belongs to `mbgatectl doctor` on the command line.
#pragma once

#include <string>

#include "ctl/request/command.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming): the library is named so
class App;
}

namespace mbgate::ctl {

class DoctorOptions {
 public:
  explicit DoctorOptions(CLI::App& app);
  DoctorOptions(const DoctorOptions&) = delete;
  DoctorOptions& operator=(const DoctorOptions&) = delete;

  [[nodiscard]] bool given() const;
  /// The error is a full sentence.
  [[nodiscard]] Result<Command, std::string> command() const;

 private:
  void add_line();
  void add_effort();
  [[nodiscard]] Result<ExaminedPort, std::string> port() const;

  CLI::App* doctor_;
  DoctorCommand words_;
  std::string device_;
  std::string baud_ = "19200";
  std::string parity_ = "even";
  std::string stop_bits_ = "1";
  std::string timeout_ = "1s";
  std::string units_;
  std::string listen_ = "2s";
};

}  // namespace mbgate::ctl
