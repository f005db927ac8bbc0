// SPDX-License-Identifier: Apache-2.0
#include <cerrno>
#include <cstring>
#include <fstream>
#include <ostream>

#include "ctl/control/event_reader.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/request/repetition.hpp"
#include "ctl/trace/trace_printer.hpp"

namespace mbgate::ctl {
namespace {

std::string cannot_write(const std::string& file) {
  return "cannot write " + file + ": " + std::strerror(errno);
}

}  // namespace

int run(const TraceCommand& command, std::ostream& out, std::ostream& errors) {
  const auto fail = [&](const std::string& why) {
    return report_failure({kExitNotDone, why}, command.json, out, errors);
  };
  std::ostream* const printed = command.quiet || command.pcapng == "-" ? nullptr : &out;
  std::ofstream file;
  if (!command.pcapng.empty() && command.pcapng != "-") {
    file.open(command.pcapng, std::ios::binary);
    if (!file) {
      return fail(cannot_write(command.pcapng));
    }
  }
  std::ostream* const capture = command.pcapng == "-"    ? &out
                                : command.pcapng.empty() ? nullptr
                                                         : &file;
  const Interruption interruption;
  TracePrinter printer(
      {command.json ? nullptr : printed, command.json ? printed : nullptr, capture, command.times});
  if (printer.start()) {
    const std::string why =
        follow_events(command.socket, trace_target(command.filter), interruption,
                      [&](const ServerEvent& event) { return printer.take(event); });
    if (!why.empty()) {
      return fail(why);
    }
  }
  if (file.is_open() && !file) {
    return fail(cannot_write(command.pcapng));
  }
  return printer.is_done() ? kExitDone : kExitNotDone;
}

}  // namespace mbgate::ctl
