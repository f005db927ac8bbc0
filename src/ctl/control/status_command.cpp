// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <boost/json/array.hpp>
#include <boost/json/serialize.hpp>
#include <chrono>
#include <fmt/core.h>
#include <ostream>

#include "config/toml/toml_value.hpp"
#include "ctl/control/control_shell.hpp"
#include "ctl/control/event_reader.hpp"
#include "ctl/control/screen_shell.hpp"
#include "ctl/control/status_text.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/request/repetition.hpp"
#include "ctl/visible_text.hpp"

namespace mbgate::ctl {
namespace {

using std::chrono::steady_clock;
using StatusAnswer = Result<std::string, Failure>;

/// mbgated itself says after 1 s that its machine does not answer.
constexpr std::chrono::seconds kAnswerLimit{5};

/// Text for people, or with --json one object on one line; both end with a newline. `give_up`: as
/// of ask_control().
StatusAnswer ask_status(const StatusCommand& command, const std::function<bool()>& give_up = {}) {
  const auto answer = ask_control(command.socket, "GET", "/api/v1/status", kAnswerLimit, give_up);
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
    return Failure{kExitNotDone, other_version(exception)};
  }
}

/// Shows a status in place of the last one. `last_answer`: its time of day; empty: there was none.
void show_page(const StatusCommand& command, const StatusAnswer& status, std::string& last_answer,
               Screen& screen) {
  const std::string now = time_of_day_now();
  std::string text =
      fmt::format("mbgatectl status, {}, every {}; q ends\n", now, config::to_text(*command.every));
  if (status) {
    text += *status;
    last_answer = now;
  } else {
    text += status.error().text + "\n";
    text += last_answer.empty() ? "" : fmt::format("The last answer came at {}.\n", last_answer);
  }
  screen.show(std::move(text));
}

/// Prints a status below the last one; with --json each on one line.
void print_block(const StatusCommand& command, const StatusAnswer& status, std::string& last_answer,
                 std::ostream& out, std::ostream& errors) {
  const std::string time = command.json ? "" : time_of_day_now() + "\n";
  if (status) {
    out << (last_answer.empty() ? "" : "\n") << time << *status;
    last_answer = time;
  } else {
    errors << time;
    report_failure(status.error(), command.json, out, errors);
  }
  out << std::flush;
}

int watch_status(const StatusCommand& command, std::ostream& out, std::ostream& errors) {
  const Interruption interruption;
  const auto screen = command.on_terminal && !command.json ? Screen::open(interruption) : nullptr;
  const auto wait_until = [&](steady_clock::time_point when) {
    return screen ? screen->wait_until(when) : interruption.wait_until(when);
  };
  bool is_to_end = false;
  const auto look = [&] {
    is_to_end = is_to_end || wait_until({});
    return is_to_end;
  };
  std::string last_answer;
  int worst = kExitDone;
  auto start = steady_clock::now();
  for (std::size_t done = 1;; ++done) {
    const auto status = ask_status(command, look);
    if (look()) {
      return kExitDone;
    }
    if (screen) {
      show_page(command, status, last_answer, *screen);
    } else {
      print_block(command, status, last_answer, out, errors);
    }
    worst = std::max(worst, status ? kExitDone : status.error().status);
    if (done == command.times || (!screen && !out)) {  // or nobody takes what is printed
      return worst;
    }
    start = next_start(start, *command.every, steady_clock::now());
    if (wait_until(start)) {
      return kExitDone;
    }
  }
}

/// mbgated itself says after 30 s that a reload takes too long.
constexpr std::chrono::seconds kReloadLimit{35};

}  // namespace

int run(const StatusCommand& command, std::ostream& out, std::ostream& errors) {
  if (command.every) {
    return watch_status(command, out, errors);
  }
  const auto status = ask_status(command);
  if (!status) {
    return report_failure(status.error(), command.json, out, errors);
  }
  out << *status;
  return kExitDone;
}

int run(const ReloadCommand& command, std::ostream& out, std::ostream& errors) {
  const auto answer = ask_control(command.socket, "POST", "/api/v1/reload", kReloadLimit);
  if (!answer) {
    return report_failure({kExitNotDone, answer.error()}, false, out, errors);
  }
  const auto* const messages = answer->json.if_contains("messages");
  if (messages == nullptr || !messages->is_array()) {
    return report_failure({kExitNotDone, error_of(*answer)}, false, out, errors);
  }
  const bool is_done = answer->status == kControlOk;
  for (const auto& message : messages->get_array()) {
    const auto* const text = message.if_string();
    (is_done ? out : errors) << visible_text(text != nullptr ? std::string_view(*text)
                                                             : "a message of another version",
                                             "\n\t")
                             << '\n';
  }
  return is_done ? kExitDone : kExitNotDone;
}

int run(const ClearCountersCommand& command, std::ostream& out, std::ostream& errors) {
  const auto answer = ask_control(command.socket, "POST", "/api/v1/clear-counters", kAnswerLimit);
  if (!answer) {
    return report_failure({kExitNotDone, answer.error()}, false, out, errors);
  }
  if (answer->status != kControlOk) {
    return report_failure({kExitNotDone, error_of(*answer)}, false, out, errors);
  }
  out << "all counters are reset\n";
  return kExitDone;
}

int run(const EventsCommand& command, std::ostream& out, std::ostream& errors) {
  const Interruption interruption;
  const auto print = [&](const ServerEvent& event) {
    out << (command.json ? visible_text(event.data) : event_line(event)) << '\n';
    return out.flush().good();
  };
  const auto why = follow_events(command.socket, "/api/v1/events", interruption, print);
  return why.empty() ? kExitNotDone
                     : report_failure({kExitNotDone, why}, command.json, out, errors);
}

}  // namespace mbgate::ctl
