// SPDX-License-Identifier: Apache-2.0
// Carries a command out: asks the server, prints what came back, says in plain words what went
// wrong.
#pragma once

#include <iosfwd>
#include <string>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// What scripts can rely on.
inline constexpr int kExitDone = 0;
inline constexpr int kExitNotDone = 1;  ///< an exception, no answer, or no connection
inline constexpr int kExitUsage = 2;

/// Values go to `out`, one a line; what went wrong goes to `errors`. Returns the exit status.
int carry_out(const Command& command, std::ostream& out, std::ostream& errors);

/// An exception for people: its number, the standard's name if it has one, and what it means for
/// the request.
std::string explain_exception(std::uint8_t code, bool is_write);

}  // namespace mbgate::ctl
