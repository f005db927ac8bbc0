// SPDX-License-Identifier: Apache-2.0
// What belongs to `mbgatectl replay` on the command line.
#pragma once

#include "ctl/request/command.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming): the library is named so
class App;
}

namespace mbgate::ctl {

class ReplayOptions {
 public:
  explicit ReplayOptions(CLI::App& app);
  ReplayOptions(const ReplayOptions&) = delete;
  ReplayOptions& operator=(const ReplayOptions&) = delete;

  [[nodiscard]] bool given() const;
  [[nodiscard]] Result<Command, std::string> command() const { return Command(words_); }

 private:
  CLI::App* replay_;
  ReplayCommand words_;
};

}  // namespace mbgate::ctl
