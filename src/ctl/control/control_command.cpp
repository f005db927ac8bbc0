// SPDX-License-Identifier: Apache-2.0
#include <boost/json/array.hpp>
#include <chrono>
#include <ostream>

#include "ctl/control/control_shell.hpp"
#include "ctl/control/event_reader.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/request/repetition.hpp"
#include "ctl/request/report.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

/// mbgated itself says after 1 s that its machine does not answer.
constexpr std::chrono::seconds kClearLimit{5};
/// mbgated itself says after 30 s that a reload takes too long.
constexpr std::chrono::seconds kReloadLimit{35};

int fail(std::ostream& errors, const std::string& why) {
  errors << "mbgatectl: " << why << '\n';
  return kExitNotDone;
}

}  // namespace

int reload(const ReloadCommand& command, std::ostream& out, std::ostream& errors) {
  const auto answer = ask_control(command.socket, "POST", "/api/v1/reload", kReloadLimit);
  if (!answer) {
    return fail(errors, answer.error());
  }
  const auto* const messages = answer->json.if_contains("messages");
  if (messages == nullptr || !messages->is_array()) {
    return fail(errors, error_of(*answer));
  }
  const bool is_done = answer->status == kControlOk;
  for (const auto& message : messages->get_array()) {
    (is_done ? out : errors) << visible_text(message.as_string(), "\n\t") << '\n';
  }
  return is_done ? kExitDone : kExitNotDone;
}

int clear_counters(const ClearCountersCommand& command, std::ostream& out, std::ostream& errors) {
  const auto answer = ask_control(command.socket, "POST", "/api/v1/clear-counters", kClearLimit);
  if (!answer) {
    return fail(errors, answer.error());
  }
  if (answer->status != kControlOk) {
    return fail(errors, error_of(*answer));
  }
  out << "all counters begin anew\n";
  return kExitDone;
}

int follow_events(const EventsCommand& command, std::ostream& out, std::ostream& errors) {
  const Interruption interruption;
  EventReader reader;
  const auto print = [&](std::string_view piece) {
    for (const ServerEvent& event : reader.take(piece)) {
      out << (command.json ? visible_text(event.data) : event_line(event)) << '\n';
    }
    return out.flush().good();
  };
  std::string why;
  try {
    why = follow_control(command.socket, "/api/v1/events", interruption, print);
  } catch (const std::exception& exception) {
    why = std::string("mbgated is of another version than mbgatectl: ") + exception.what();
  }
  return why.empty() ? kExitNotDone
                     : report_failure({kExitNotDone, why}, command.json, out, errors);
}

}  // namespace mbgate::ctl
