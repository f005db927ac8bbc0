// SPDX-License-Identifier: Apache-2.0
// The subcommands of mbgatectl: what each has on the command line, and which command it is then.
//
// To change
// - a type of value, or its output, in mbgatectl: ctl/request/value_text; as lines or JSON:
//   ctl/request/report.cpp.
// - the checks of mbgatectl --tls, and its messages when a handshake fails: ctl/tls/handshake; its
//   options: subcommands.
// - the output of mbgatectl trace: ctl/trace/trace_lines; from JSON: ctl/trace/trace_event; the
//   capture: ctl/trace/trace_capture; which bytes Wireshark takes for frames:
//   ctl/trace/bus_packets.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <stdexcept>
#include <string>
#include <variant>

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

// Options that several subcommands have, and what their words mean. Wrong words throw WrongUsage.

/// The value, if there is one.
template <typename Value>
Value expect(const Result<Value, std::string>& result) {
  if (!result) {
    throw WrongUsage(result.error());
  }
  return *result;
}

/// `text` as a time that is not shorter than `least`.
std::chrono::nanoseconds parse_time(const std::string& text, std::chrono::milliseconds least);

/// Which server a command asks, and whether over TLS.
struct ServerWords {
  Target target;
  std::string timeout = "5s";
  std::optional<std::uint16_t> port;
  bool tls = false;
  TlsIdentity identity;
};

// `command` keeps references to what these write into.
void add_server(CLI::App& command, ServerWords& words);
void add_tls(CLI::App& command, ServerWords& words);
void add_profile_folder(CLI::App& command, std::optional<std::filesystem::path>& folder);
/// --control: where mbgated is asked; over TCP only by what only reads.
void add_control(CLI::App& command, std::string& socket, bool only_reads);

/// The server; its unit is not set.
Target target_of(const ServerWords& words);

/// Text to print instead of running a command: help or the version (status 0), or an error (status
/// 2).
struct Notice {
  int status;
  std::string text;
};

/// Parses "mbgatectl read holding 0x1E --type i32 --unit 1". `version` is what --version prints.
std::variant<Command, Notice> parse_command_line(const std::string& version, int count,
                                                 const char* const* arguments);

}  // namespace mbgate::ctl
