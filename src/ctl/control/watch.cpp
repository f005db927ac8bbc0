// SPDX-License-Identifier: Apache-2.0
#include "ctl/control/watch.hpp"

#include <algorithm>
#include <chrono>
#include <ostream>

#include "config/toml/duration_text.hpp"
#include "ctl/control/screen_shell.hpp"
#include "ctl/control/status_question.hpp"
#include "ctl/request/carry_out.hpp"
#include "ctl/request/interruption.hpp"
#include "ctl/request/period.hpp"

namespace mbgate::ctl {
namespace {

using std::chrono::steady_clock;

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
      : screen_(screen), rest_of_title_(", every " + config::to_text(every) + "; q ends\n") {}

  void show(const StatusAnswer& status) {
    const std::string time = time_now();
    std::string text = "mbgatectl status, " + time + rest_of_title_;
    if (status) {
      text += *status;
      last_answer_ = time;
    } else {
      text += status.error().text + "\n";
      text += last_answer_.empty() ? "" : "The last answer came at " + last_answer_ + ".\n";
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

}  // namespace

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

}  // namespace mbgate::ctl
