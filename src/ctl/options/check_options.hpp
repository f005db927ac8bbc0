// SPDX-License-Identifier: Apache-2.0
// What belongs to `mbgatectl check` on the command line.
#pragma once

#include "ctl/request/command.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming): the library is named so
class App;
}

namespace mbgate::ctl {

class CheckOptions {
 public:
  explicit CheckOptions(CLI::App& app);
  CheckOptions(const CheckOptions&) = delete;
  CheckOptions& operator=(const CheckOptions&) = delete;

  [[nodiscard]] bool given() const;
  [[nodiscard]] Result<Command, std::string> command() const { return Command(words_); }

 private:
  CLI::App* check_;
  CheckCommand words_;
};

}  // namespace mbgate::ctl
