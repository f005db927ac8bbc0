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
    case 0x06: return "the request was not carried out: gateway or device is busy; try again";
    case 0x08: return "the device's memory has a parity error";
    case 0x0A:
      return "never transmitted (a broadcast: not on each of its buses): no route, no such device, "
             "its line is closed, or it was a write to a device that does not answer";
    case 0x0B: return "no valid answer came";
    default: return "a code of the device's maker; its manual says what it means";
  }
}

}  // namespace

int carry_out(const Command& command, std::ostream& out, std::ostream& errors) {
  return std::visit([&](const auto& it) { return run(it, out, errors); }, command);
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

namespace {

using std::chrono::steady_clock;
using std::chrono::system_clock;

/// One command's reads, and where their values go.
class Reads {
 public:
  Reads(const ReadCommand& command, const modbus::Request& request, std::ostream& out,
        std::ostream& errors)
      : command_(command),
        request_(request),
        out_(out),
        errors_(errors),
        connection_(command.target) {}

  /// Reads once and prints what came. Returns the exit status of this read.
  int read(const Interruption& interruption) {
    const bool with_time = !command_.quiet && !command_.json;
    const auto time = with_time ? time_of_day(system_clock::now()) + "\n" : std::string();
    const auto response = interruption.endable([&] { return connection_.ask(request_); });
    if (!response) {
      errors_ << time;
      const int status = report_failure(response.error(), command_.json, out_, errors_);
      out_ << std::flush;
      return status;
    }
    out_ << time << read_report(command_, response_values(command_, *response)) << std::flush;
    return kExitDone;
  }

 private:
  const ReadCommand& command_;
  const modbus::Request& request_;
  std::ostream& out_;
  std::ostream& errors_;
  Connection connection_;
};

int repeat_read(const ReadCommand& command, const modbus::Request& request, std::ostream& out,
                std::ostream& errors) {
  const Interruption interruption;
  Reads reads(command, request, out, errors);
  int status = kExitDone;
  auto start = steady_clock::now();
  for (std::size_t done = 1;; ++done) {
    status = std::max(status, reads.read(interruption));
    const bool last = done == command.times || !out;  // or nobody can take what is printed
    if (!last) {
      start = next_start(start, *command.every, steady_clock::now());
    }
    if (interruption.wait_until(start)) {
      return kExitDone;
    }
    if (last) {
      return out ? status : kExitNotDone;
    }
  }
}

}  // namespace

int run(const ReadCommand& command, std::ostream& out, std::ostream& errors) {
  const auto request = make_request(command);
  if (!request) {
    return report_failure({kExitUsage, request.error()}, command.json, out, errors);
  }
  if (command.every) {
    return repeat_read(command, *request, out, errors);
  }
  const auto response = Connection(command.target).ask(*request);
  if (!response) {
    return report_failure(response.error(), command.json, out, errors);
  }
  out << read_report(command, response_values(command, *response));
  return kExitDone;
}

}  // namespace mbgate::ctl
