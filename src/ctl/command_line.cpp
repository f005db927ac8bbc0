// SPDX-License-Identifier: Apache-2.0
#include "ctl/command_line.hpp"

#include <CLI/CLI.hpp>
#include <sstream>

#include "ctl/options/check_options.hpp"
#include "ctl/options/control_options.hpp"
#include "ctl/options/doctor_options.hpp"
#include "ctl/options/profile_options.hpp"
#include "ctl/options/replay_options.hpp"
#include "ctl/options/request_options.hpp"
#include "ctl/options/scan_options.hpp"
#include "ctl/options/trace_options.hpp"
#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {
namespace {

struct Subcommands {
  explicit Subcommands(CLI::App& app)
      : read(app),
        write(app),
        profile(app),
        scan(app),
        check(app),
        replay(app),
        doctor(app),
        status(app),
        reload(app),
        clear_counters(app),
        events(app),
        trace(app) {}

  /// That of the subcommand which was given. The error is a full sentence.
  [[nodiscard]] Result<Command, std::string> command() const {
    if (read.given()) {
      return read.command();
    }
    if (write.given()) {
      return write.command();
    }
    if (profile.given()) {
      return profile.command();
    }
    if (scan.given()) {
      return scan.command();
    }
    if (check.given()) {
      return check.command();
    }
    if (replay.given()) {
      return replay.command();
    }
    if (doctor.given()) {
      return doctor.command();
    }
    if (status.given()) {
      return status.command();
    }
    if (reload.given()) {
      return reload.command();
    }
    if (trace.given()) {
      return trace.command();
    }
    return clear_counters.given() ? clear_counters.command() : events.command();
  }

  ReadOptions read;
  WriteOptions write;
  ProfileOptions profile;
  ScanOptions scan;
  CheckOptions check;
  ReplayOptions replay;
  DoctorOptions doctor;
  StatusOptions status;
  ReloadOptions reload;
  ClearCountersOptions clear_counters;
  EventsOptions events;
  TraceOptions trace;
};

}  // namespace

std::variant<Command, Notice> parse_command_line(const std::string& version, int count,
                                                 const char* const* arguments) {
  CLI::App app(
      "Reads and writes Modbus devices through a gateway, or any Modbus TCP server, finds out what "
      "is on a bus and what is wrong with a line, shows drive profiles, checks a configuration, "
      "replays a recording, and asks a running mbgated how it is.",
      "mbgatectl");
  app.set_version_flag("--version", "mbgatectl " + version);
  app.require_subcommand(1);
  app.get_formatter()->column_width(22);
  Subcommands subcommands(app);  // CLI11 writes into it
  try {
    app.parse(count, arguments);
  } catch (const CLI::ParseError& error) {
    std::ostringstream text;
    const int status = app.exit(error, text, text);
    return Notice{status == 0 ? kExitDone : kExitUsage,
                  status == 0 ? text.str() : "mbgatectl: " + text.str()};
  }
  const auto command = subcommands.command();
  if (!command) {
    return Notice{kExitUsage, "mbgatectl: " + command.error() + "\n"};
  }
  return *command;
}

}  // namespace mbgate::ctl
