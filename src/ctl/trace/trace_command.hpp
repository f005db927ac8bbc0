// SPDX-License-Identifier: Apache-2.0
// Reads along what goes through a running mbgated.
#pragma once

#include <iosfwd>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// Prints each record, and writes it to a capture file if one is named, until a signal comes or
/// there were enough of them, which is kExitDone, or mbgated ends.
int follow_trace(const TraceCommand& command, std::ostream& out, std::ostream& errors);

}  // namespace mbgate::ctl
