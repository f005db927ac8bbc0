// SPDX-License-Identifier: Apache-2.0
// What an operator asks a running mbgated: how it is, to read its configuration again, to clear
// its counters, and what it says from now on.
#pragma once

#include <iosfwd>

#include "ctl/request/command.hpp"

namespace mbgate::ctl {

/// Prints the state of lines, drives and clients, what is not well first; or JSON as it came. With
/// `command.every` again and again.
int show_status(const StatusCommand& command, std::ostream& out, std::ostream& errors);
/// Returns when the new configuration is in force, or was refused: then the reasons are printed.
int reload(const ReloadCommand& command, std::ostream& out, std::ostream& errors);
int clear_counters(const ClearCountersCommand& command, std::ostream& out, std::ostream& errors);
/// Prints what the journal gets, until a signal comes, which is kExitDone, or mbgated ends.
int follow_events(const EventsCommand& command, std::ostream& out, std::ostream& errors);

}  // namespace mbgate::ctl
