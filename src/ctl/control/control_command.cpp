// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/control_command.hpp"

#include <boost/json/array.hpp>
#include <boost/json/serialize.hpp>
#include <chrono>
#include <exception>
#include <ostream>

#include "ctl/control/control_shell.hpp"
#include "ctl/control/status_text.hpp"
#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {
namespace {

constexpr unsigned kOk = 200;
/// mbgated itself says after 1 s that its machine does not answer, and after 30 s that a reload
/// takes too long.
constexpr std::chrono::seconds kStatusLimit{5};
constexpr std::chrono::seconds kReloadLimit{35};

int fail(std::ostream& errors, const std::string& why) {
  errors << "mbgatectl: " << why << '\n';
  return kExitNotDone;
}

std::string error_of(const ControlAnswer& answer) {
  const auto* const error = answer.json.if_contains("error");
  return error != nullptr && error->is_string()
             ? std::string(error->get_string())
             : "unexpected answer, HTTP status " + std::to_string(answer.status);
}

}  // namespace

int show_status(const StatusCommand& command, std::ostream& out, std::ostream& errors) {
  const auto answer = ask_control(command.socket, "GET", "/api/v1/status", kStatusLimit);
  if (!answer) {
    return fail(errors, answer.error());
  }
  if (answer->status != kOk) {
    return fail(errors, error_of(*answer));
  }
  if (command.json) {
    out << boost::json::serialize(answer->json) << '\n';
    return kExitDone;
  }
  try {
    out << status_text(answer->json);
  } catch (const std::exception& exception) {
    return fail(errors,
                std::string("mbgated is of another version than mbgatectl: ") + exception.what());
  }
  return kExitDone;
}

int reload(const ReloadCommand& command, std::ostream& out, std::ostream& errors) {
  const auto answer = ask_control(command.socket, "POST", "/api/v1/reload", kReloadLimit);
  if (!answer) {
    return fail(errors, answer.error());
  }
  const auto* const messages = answer->json.if_contains("messages");
  if (messages == nullptr || !messages->is_array()) {
    return fail(errors, error_of(*answer));
  }
  const bool is_done = answer->status == kOk;
  for (const auto& message : messages->get_array()) {
    (is_done ? out : errors) << std::string_view(message.as_string()) << '\n';
  }
  return is_done ? kExitDone : kExitNotDone;
}

}  // namespace mbgate::ctl
