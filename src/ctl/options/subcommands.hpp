// SPDX-License-Identifier: Apache-2.0
// The subcommands of mbgatectl: what each has on the command line, and which command it is then.
#pragma once

#include <functional>
#include <stdexcept>

#include "ctl/request/command.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming): the library is named so
class App;
}

namespace mbgate::ctl {

/// Gets the command that a command line asks for.
using Choose = std::function<void(const Command&)>;

/// What CLI11 lets through, and means nothing all the same; a full sentence.
class WrongUsage : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Each adds a subcommand. Parsing a line that has it calls `choose`, or throws WrongUsage.
void add_read(CLI::App& app, const Choose& choose);
void add_write(CLI::App& app, const Choose& choose);
void add_profile(CLI::App& app, const Choose& choose);
void add_scan(CLI::App& app, const Choose& choose);
void add_check(CLI::App& app, const Choose& choose);
void add_replay(CLI::App& app, const Choose& choose);
void add_doctor(CLI::App& app, const Choose& choose);
void add_status(CLI::App& app, const Choose& choose);
void add_reload(CLI::App& app, const Choose& choose);
void add_clear_counters(CLI::App& app, const Choose& choose);
void add_events(CLI::App& app, const Choose& choose);
void add_trace(CLI::App& app, const Choose& choose);

}  // namespace mbgate::ctl
