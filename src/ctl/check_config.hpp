// SPDX-License-Identifier: Apache-2.0
// `mbgatectl check`: is the configuration right? It asks the same functions as `mbgated --check`.
#pragma once

#include <iosfwd>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// Prints errors and warnings to `errors` and, if there is no error, what is configured to `out`.
/// Opens no port and asks nobody. Returns the exit status: kExitDone or kExitConfiguration.
int check_config(const CheckCommand& command, std::ostream& out, std::ostream& errors);

}  // namespace mbgate::ctl
