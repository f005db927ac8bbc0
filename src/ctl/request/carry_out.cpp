// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/carry_out.hpp"

#include <ostream>
#include <string_view>

#include "ctl/check_config.hpp"
#include "ctl/control/control_command.hpp"
#include "ctl/doctor/doctor_command.hpp"
#include "ctl/profile/show_profile.hpp"
#include "ctl/replay/replay_command.hpp"
#include "ctl/request/connection.hpp"
#include "ctl/request/repeated_read.hpp"
#include "ctl/request/report.hpp"
#include "ctl/scan/scan_command.hpp"
#include "ctl/trace/trace_command.hpp"
#include "modbus/exception_code.hpp"

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

int carry_out_one(const ReadCommand& command, std::ostream& out, std::ostream& errors) {
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

int carry_out_one(const WriteCommand& command, std::ostream& out, std::ostream& errors) {
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

int carry_out_one(const ProfileCommand& command, std::ostream& out, std::ostream& errors) {
  return show_profile(command, out, errors);
}

int carry_out_one(const ScanCommand& command, std::ostream& out, std::ostream& errors) {
  return carry_out_scan(command, out, errors);
}

int carry_out_one(const CheckCommand& command, std::ostream& out, std::ostream& errors) {
  return check_config(command, out, errors);
}

int carry_out_one(const ReplayCommand& command, std::ostream& out, std::ostream& errors) {
  return replay_recording(command, out, errors);
}

int carry_out_one(const DoctorCommand& command, std::ostream& out, std::ostream& errors) {
  return carry_out_doctor(command, out, errors);
}

int carry_out_one(const StatusCommand& command, std::ostream& out, std::ostream& errors) {
  return show_status(command, out, errors);
}

int carry_out_one(const ReloadCommand& command, std::ostream& out, std::ostream& errors) {
  return reload(command, out, errors);
}

int carry_out_one(const ClearCountersCommand& command, std::ostream& out, std::ostream& errors) {
  return clear_counters(command, out, errors);
}

int carry_out_one(const EventsCommand& command, std::ostream& out, std::ostream& errors) {
  return follow_events(command, out, errors);
}

int carry_out_one(const TraceCommand& command, std::ostream& out, std::ostream& errors) {
  return follow_trace(command, out, errors);
}

}  // namespace

int carry_out(const Command& command, std::ostream& out, std::ostream& errors) {
  return std::visit([&](const auto& one) { return carry_out_one(one, out, errors); }, command);
}

std::string explain_exception(std::uint8_t code, bool is_write) {
  std::string text = modbus::exception_text(code);
  text.append(": ").append(meaning(code));
  if (is_write &&
      code == static_cast<std::uint8_t>(modbus::ExceptionCode::gateway_target_failed_to_respond)) {
    text.append("; the write may have been done");
  }
  return text;
}

}  // namespace mbgate::ctl
