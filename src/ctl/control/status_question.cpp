// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/status_question.hpp"

#include <boost/json/serialize.hpp>
#include <chrono>
#include <exception>

#include "ctl/control/control_shell.hpp"
#include "ctl/control/status_text.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

/// mbgated itself says after 1 s that its machine does not answer.
constexpr std::chrono::seconds kStatusLimit{5};

}  // namespace

StatusAnswer ask_status(const StatusCommand& command, const std::function<bool()>& give_up) {
  const auto answer = ask_control(command.socket, "GET", "/api/v1/status", kStatusLimit, give_up);
  if (!answer) {
    return Failure{kExitNotDone, answer.error()};
  }
  if (answer->status != kControlOk) {
    return Failure{kExitNotDone, error_of(*answer)};
  }
  if (command.json) {
    return visible_text(boost::json::serialize(answer->json)) + "\n";
  }
  try {
    return status_text(answer->json);
  } catch (const std::exception& exception) {
    return Failure{kExitNotDone, std::string("mbgated is of another version than mbgatectl: ") +
                                     exception.what()};
  }
}

}  // namespace mbgate::ctl
