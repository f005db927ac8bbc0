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
constexpr std::chrono::seconds kStatusLimit{5};

/// Text for people, or with --json one object on one line; both end with a newline. `give_up`: as
/// of ask_control().
StatusAnswer ask_status(const StatusCommand& command, const std::function<bool()>& give_up = {}) {
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
    return Failure{kExitNotDone, fmt::format("mbgated and mbgatectl have different versions: {}",
                                             exception.what())};
  }
}

std::string time_now() { return time_of_day(std::chrono::system_clock::now()); }

/// Prints one status below the other; with --json each on one line.
class Blocks {
 public:
  Blocks(const Interruption& interruption, bool json, std::ostream& out, std::ostream& errors)
      : interruption_(interruption), json_(json), out_(out), errors_(errors) {}

  void show(const StatusAnswer& status) {
    const std::string time = json_ ? "" : time_now() + "\n";
    if (status) {
      out_ << (is_first_ || json_ ? "" : "\n") << time << *status;
      is_first_ = false;
    } else {
      errors_ << time;
      report_failure(status.error(), json_, out_, errors_);
    }
    out_ << std::flush;
  }

  [[nodiscard]] bool wait_until(steady_clock::time_point when) const {
    return interruption_.wait_until(when);
  }

  /// Is there anybody who takes what is printed?
  [[nodiscard]] bool is_read() const { return bool{out_}; }

 private:
  const Interruption& interruption_;
  bool json_;
  std::ostream& out_;
  std::ostream& errors_;
  bool is_first_ = true;
};

/// Shows each status in place of the last one.
class InPlace {
 public:
  InPlace(Screen& screen, std::chrono::nanoseconds every)
      : screen_(screen),
        rest_of_title_(fmt::format(", every {}; q ends\n", config::to_text(every))) {}

  void show(const StatusAnswer& status) {
    const std::string time = time_now();
    std::string text = fmt::format("mbgatectl status, {}{}", time, rest_of_title_);
    if (status) {
      text += *status;
      last_answer_ = time;
    } else {
      text += status.error().text + "\n";
      text +=
          last_answer_.empty() ? "" : fmt::format("The last answer came at {}.\n", last_answer_);
    }
    screen_.show(std::move(text));
  }

  [[nodiscard]] bool wait_until(steady_clock::time_point when) { return screen_.wait_until(when); }
  [[nodiscard]] static bool is_read() { return true; }

 private:
  Screen& screen_;
  std::string rest_of_title_;
  std::string last_answer_;  ///< its time of day; empty: there was none
};

template <typename Display>
int watch_on(Display& display, const StatusCommand& command) {
  bool is_to_end = false;
  const auto look = [&] {
    is_to_end = is_to_end || display.wait_until({});
    return is_to_end;
  };
  int worst = kExitDone;
  auto start = steady_clock::now();
  for (std::size_t done = 1;; ++done) {
    const auto status = ask_status(command, look);
    if (look()) {
      return kExitDone;
    }
    display.show(status);
    worst = std::max(worst, status ? kExitDone : status.error().status);
    if (!display.is_read()) {
      return kExitNotDone;
    }
    if (done == command.times) {
      return worst;
    }
    start = next_start(start, *command.every, steady_clock::now());
    if (display.wait_until(start)) {
      return kExitDone;
    }
  }
}

int watch_status(const StatusCommand& command, std::ostream& out, std::ostream& errors) {
  const Interruption interruption;
  if (command.on_terminal && !command.json) {
    if (const auto screen = Screen::open(interruption)) {
      InPlace display(*screen, *command.every);
      return watch_on(display, command);
    }
  }
  Blocks display(interruption, command.json, out, errors);
  return watch_on(display, command);
}

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

int run(const ReloadCommand& command, std::ostream& out, std::ostream& errors) {
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

int run(const ClearCountersCommand& command, std::ostream& out, std::ostream& errors) {
  const auto answer = ask_control(command.socket, "POST", "/api/v1/clear-counters", kClearLimit);
  if (!answer) {
    return fail(errors, answer.error());
  }
  if (answer->status != kControlOk) {
    return fail(errors, error_of(*answer));
  }
  out << "all counters are reset\n";
  return kExitDone;
}

int run(const EventsCommand& command, std::ostream& out, std::ostream& errors) {
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
    why = fmt::format("mbgated and mbgatectl have different versions: {}", exception.what());
  }
  return why.empty() ? kExitNotDone
                     : report_failure({kExitNotDone, why}, command.json, out, errors);
}

}  // namespace mbgate::ctl
