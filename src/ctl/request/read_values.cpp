// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <chrono>
#include <ostream>

#include "ctl/request/carry_out.hpp"
#include "ctl/request/connection.hpp"
#include "ctl/request/repetition.hpp"
#include "ctl/request/report.hpp"

namespace mbgate::ctl {
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

int read_values(const ReadCommand& command, std::ostream& out, std::ostream& errors) {
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
