// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/carry_out.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/core.h>
#include <ostream>
#include <string_view>

#include "config/load.hpp"
#include "ctl/request/repetition.hpp"
#include "modbus/codes.hpp"

namespace mbgate::ctl {
namespace {

/// What the code means to the one who asked, be it made by the device or by a gateway on the way.
std::string_view meaning(std::uint8_t code) {
  switch (code) {
    case 0x01: return "the device does not know this function, or the gateway does not allow it";
    case 0x02:
      return "there is no such register or coil, or it lies outside every window of the route";
    case 0x03: return "the device refuses the value or the number of values";
    case 0x04: return "the device failed while it carried the request out";
    case 0x05: return "the device has accepted the request and is still working on it";
    case 0x06:
      return "the request was not carried out: gateway or device is busy, or it was a write to a "
             "device that does not answer; try again";
    case 0x08: return "the device's memory has a parity error";
    case 0x0A:
      return "never transmitted (a broadcast: not on each of its buses): no route, no such device, "
             "or its line is closed";
    case 0x0B: return "no valid answer came";
    default: return "a code of the device's maker; its manual says what it means";
  }
}

using std::chrono::steady_clock;

/// Prints what came, under its time. Returns the exit status of this read.
int report_read(const ReadCommand& command, const std::string& time,
                const Result<modbus::Pdu, Failure>& response, std::ostream& out,
                std::ostream& errors) {
  if (!response) {
    errors << time;
    return report_failure(response.error(), command.json, out, errors);
  }
  out << time << read_report(command, response_values(command, *response));
  return kExitDone;
}

int repeat_read(const ReadCommand& command, const modbus::Request& request, std::ostream& out,
                std::ostream& errors) {
  const Interruption interruption;
  Connection connection(command.target);
  const bool with_time = !command.quiet && !command.json;
  int status = kExitDone;
  auto start = steady_clock::now();
  for (std::size_t done = 1;; ++done) {
    const auto time = with_time ? time_of_day_now() + "\n" : std::string();
    const auto response = interruption.endable([&] { return connection.ask(request); });
    status = std::max(status, report_read(command, time, response, out, errors));
    out << std::flush;
    const bool last = done == command.times || !out;  // or nobody can take what is printed
    if (!last) {
      start = next_start(start, *command.every, steady_clock::now());
    }
    if (interruption.wait_until(start)) {
      return kExitDone;
    }
    if (last) {
      return status;
    }
  }
}

}  // namespace

int carry_out(const Command& command, std::ostream& out, std::ostream& errors) {
  const int status = std::visit([&](const auto& it) { return run(it, out, errors); }, command);
  if (status == kExitDone && !out.flush()) {
    errors << "mbgatectl: done, but the result cannot be written to standard output\n";
    return kExitNotDone;
  }
  return status;
}

int run(const WriteCommand& command, std::ostream& out, std::ostream& errors) {
  const auto request = make_request(command);
  if (!request) {
    return report_failure({kExitUsage, request.error()}, command.json, out, errors);
  }
  const auto response = Connection(command.target).ask(*request);
  if (!response) {
    return report_failure(response.error(), command.json, out, errors);
  }
  out << write_report(command);
  return kExitDone;
}

int run(const CheckCommand& command, std::ostream& out, std::ostream& errors) {
  const auto loaded = config::load_settings(command.config, {.folder = command.folder});
  errors << config::render(loaded.diagnostics) << std::flush;
  if (!loaded.settings) {
    return kExitConfiguration;
  }
  out << config::check_summary(*loaded.settings) << '\n';
  return kExitDone;
}

std::string explain_exception(std::uint8_t code, bool is_write) {
  const bool is_unknown =
      is_write &&
      code == static_cast<std::uint8_t>(modbus::ExceptionCode::gateway_target_failed_to_respond);
  return fmt::format("{}: {}{}", modbus::exception_text(code), meaning(code),
                     is_unknown ? "; the write may have been done" : "");
}

int run(const ReadCommand& command, std::ostream& out, std::ostream& errors) {
  const auto request = make_request(command);
  if (!request) {
    return report_failure({kExitUsage, request.error()}, command.json, out, errors);
  }
  if (command.every) {
    return repeat_read(command, *request, out, errors);
  }
  return report_read(command, {}, Connection(command.target).ask(*request), out, errors);
}

}  // namespace mbgate::ctl
