// SPDX-License-Identifier: Apache-2.0
// Runs a command: sends the request to the server, prints the response, and explains errors in
// plain words.
#pragma once

#include <iosfwd>
#include <string>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// Exit statuses that scripts can rely on.
inline constexpr int kExitDone = 0;
inline constexpr int kExitNotDone = 1;  ///< an exception, no answer, or no connection
inline constexpr int kExitUsage = 2;
inline constexpr int kExitConfiguration = 78;  ///< a configuration or a recording is wrong

/// Prints values to `out`, one on each line, and errors to `errors`; with --json both to `out`.
/// Returns the exit status.
int carry_out(const Command& command, std::ostream& out, std::ostream& errors);

/// An exception for people: its number, the standard's name if it has one, and what it means for
/// the request.
std::string explain_exception(std::uint8_t code, bool is_write);

}  // namespace mbgate::ctl
