// SPDX-License-Identifier: Apache-2.0
// mbgatectl: the operator's hand. Exit status 0 done, 1 an exception, no answer or a replay that
// differs, 2 wrong usage, 78 a wrong configuration or recording.
#include <unistd.h>

#include <iostream>

#include "ctl/options/subcommands.hpp"
#include "ctl/request/carry_out.hpp"
#include "sys/unique_fd.hpp"

int main(int argc, char** argv) {
  mbgate::sys::open_standard_streams();
  auto parsed = mbgate::ctl::parse_command_line(MBGATE_VERSION, argc, argv);
  if (const auto* notice = std::get_if<mbgate::ctl::Notice>(&parsed)) {
    (notice->status == 0 ? std::cout : std::cerr) << notice->text;
    return notice->status;
  }
  auto& command = std::get<mbgate::ctl::Command>(parsed);
  if (auto* scan = std::get_if<mbgate::ctl::ScanCommand>(&command)) {
    scan->show_progress = isatty(STDERR_FILENO) == 1;
  }
  if (auto* status = std::get_if<mbgate::ctl::StatusCommand>(&command)) {
    status->on_terminal = isatty(STDOUT_FILENO) == 1;
  }
  return mbgate::ctl::carry_out(command, std::cout, std::cerr);
}
