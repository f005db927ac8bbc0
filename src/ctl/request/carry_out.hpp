// SPDX-License-Identifier: Apache-2.0
// Runs the commands, and explains exceptions in plain words.
#pragma once

#include <cstdint>
#include <iosfwd>
#include <span>
#include <string>

#include "ctl/request/command.hpp"
#include "ctl/request/modbus_client.hpp"

namespace mbgate::ctl {

/// Exit statuses that scripts can rely on.
inline constexpr int kExitDone = 0;
inline constexpr int kExitNotDone = 1;  ///< an exception, no answer, or no connection
inline constexpr int kExitUsage = 2;
inline constexpr int kExitConfiguration = 78;  ///< a configuration or a recording is wrong

/// Prints what the command asks for to `out` and errors to `errors`; with --json both to `out`, one
/// JSON object a line. Returns the exit status.
int carry_out(const Command& command, std::ostream& out, std::ostream& errors);

// What it calls for each kind.

/// With `command.every` again and again, until `command.times` is reached, or a signal comes: then
/// it is kExitDone. A read that fails is reported, and the next one done.
int run(const ReadCommand& command, std::ostream& out, std::ostream& errors);
int run(const WriteCommand& command, std::ostream& out, std::ostream& errors);
/// The profile, or the list of all. No gateway is contacted.
int run(const ProfileCommand& command, std::ostream& out, std::ostream& errors);
/// Over a connection, or at a serial port: the table of what was found, which is kExitDone, and a
/// configuration, which may go to a file that must not exist yet.
int run(const ScanCommand& command, std::ostream& out, std::ostream& errors);
/// Errors and warnings; if there is no error, what is configured. It asks the same functions as
/// `mbgated --check`.
int run(const CheckCommand& command, std::ostream& out, std::ostream& errors);
/// That every action is the recorded one, or the first that is not, which is kExitNotDone.
int run(const ReplayCommand& command, std::ostream& out, std::ostream& errors);
/// A line for each step as it is done; with --json one object at the end. A fault that was found is
/// kExitNotDone.
int run(const DoctorCommand& command, std::ostream& out, std::ostream& errors);
/// The state of lines, drives and clients, faults first. With `command.every` again and
/// again, on a screen or as blocks of text, also where mbgated does not answer.
int run(const StatusCommand& command, std::ostream& out, std::ostream& errors);
/// Returns when the new configuration is in force, or was refused: then the reasons are printed.
int run(const ReloadCommand& command, std::ostream& out, std::ostream& errors);
int run(const ClearCountersCommand& command, std::ostream& out, std::ostream& errors);
/// What the journal gets, until a signal comes, which is kExitDone, or mbgated ends.
int run(const EventsCommand& command, std::ostream& out, std::ostream& errors);
/// Each record, also to a capture file if one is named, until a signal comes or there were enough
/// of them, which is kExitDone, or mbgated ends.
int run(const TraceCommand& command, std::ostream& out, std::ostream& errors);

/// An exception for people: its number, the standard's name if it has one, and what it means for
/// the request.
std::string explain_exception(std::uint8_t code, bool is_write);

/// The values that were read: "30: 200000 (0x00030D40)" a line, or the plain values, or
/// {"unit":1,"table":"holding","values":[{"address":30,"value":200000}]}.
std::string read_report(const ReadCommand& command, std::span<const std::uint64_t> values);

/// "30: 200000 (0x00030D40) written" a line, or
/// {"unit":1,"table":"holding","address":30,"written":1}.
std::string write_report(const WriteCommand& command);

/// Prints a failure in words to `errors`, or as JSON to `out`: {"error":"...","exception":11}, the
/// second only if an exception came. Returns its exit status.
int report_failure(const Failure& failure, bool as_json, std::ostream& out, std::ostream& errors);

}  // namespace mbgate::ctl
