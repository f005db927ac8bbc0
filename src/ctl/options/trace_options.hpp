// SPDX-License-Identifier: Apache-2.0
// What belongs to `mbgatectl trace` on the command line.
#pragma once

#include <string>

#include "ctl/request/command.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming): the library is named so
class App;
}

namespace mbgate::ctl {

class TraceOptions {
 public:
  explicit TraceOptions(CLI::App& app);
  TraceOptions(const TraceOptions&) = delete;
  TraceOptions& operator=(const TraceOptions&) = delete;

  [[nodiscard]] bool given() const;
  /// The error is a full sentence.
  [[nodiscard]] Result<Command, std::string> command() const;

 private:
  CLI::App* trace_;
  TraceCommand words_;
  std::string function_;
};

}  // namespace mbgate::ctl
