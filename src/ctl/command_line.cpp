// SPDX-License-Identifier: Apache-2.0
#include "ctl/command_line.hpp"

#include <CLI/CLI.hpp>
#include <fmt/core.h>
#include <optional>
#include <sstream>

#include "ctl/options/subcommands.hpp"
#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {

std::variant<Command, Notice> parse_command_line(const std::string& version, int count,
                                                 const char* const* arguments) {
  CLI::App app(
      "Reads and writes Modbus devices through mbgated or any other Modbus TCP server, shows the "
      "status of a running mbgated, scans and examines serial lines, shows drive profiles, checks "
      "configurations, and replays recordings.",
      "mbgatectl");
  app.set_version_flag("--version", "mbgatectl " + version);
  app.require_subcommand(1);
  app.get_formatter()->column_width(22);
  std::optional<Command> chosen;
  for (const auto add :
       {add_read, add_write, add_profile, add_scan, add_check, add_replay, add_doctor, add_status,
        add_reload, add_clear_counters, add_events, add_trace}) {
    add(app, [&chosen](const Command& command) { chosen = command; });
  }
  try {
    app.parse(count, arguments);
  } catch (const WrongUsage& error) {
    return Notice{kExitUsage, fmt::format("mbgatectl: {}\n", error.what())};
  } catch (const CLI::ParseError& error) {
    std::ostringstream text;
    const int status = app.exit(error, text, text);
    return Notice{status == 0 ? kExitDone : kExitUsage,
                  status == 0 ? text.str() : "mbgatectl: " + text.str()};
  }
  return *std::move(chosen);
}

}  // namespace mbgate::ctl
