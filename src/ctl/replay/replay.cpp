// SPDX-License-Identifier: Apache-2.0
#include "ctl/replay/replay.hpp"

#include <fmt/core.h>
#include <limits>
#include <utility>
#include <vector>

#include "config/load.hpp"
#include "gateway/gateway.hpp"
#include "report/recording/record.hpp"

namespace mbgate::ctl {
namespace {

using gateway::Gateway;

/// More than a century, and far enough from the end of the clock for every timeout.
constexpr gateway::Instant kLastInstant{
    gateway::Duration(std::numeric_limits<std::int64_t>::max() / 2)};

/// Why the instant of an input cannot be this one, or nothing. `first`: that of the input before.
std::string wrong_instant(gateway::Instant at, gateway::Instant first) {
  const auto count_of = [](gateway::Instant instant) {
    return std::to_string(instant.time_since_epoch().count());
  };
  return at >= first && at <= kLastInstant
             ? std::string()
             : fmt::format("expected an instant from {} to {}, found {}", count_of(first),
                           count_of(kLastInstant), count_of(at));
}

/// The lines of the recording, counted.
class RecordedLines {
 public:
  explicit RecordedLines(std::istream& stream) : stream_(stream) {}
  /// False at the end; a last line without its newline was cut off, and does not count.
  bool next() {
    ++number_;
    return std::getline(stream_, line_) && !stream_.eof();
  }
  [[nodiscard]] const std::string& line() const { return line_; }
  [[nodiscard]] std::size_t number() const { return number_; }

 private:
  std::istream& stream_;
  std::string line_;
  std::size_t number_ = 0;
};

/// What is wrong with the head, or nothing.
std::string read_head(RecordedLines& lines, report::HeadReader& reader) {
  while (lines.next()) {
    const auto complete = reader.read(lines.line());
    if (!complete) {
      return complete.error();
    }
    if (*complete) {
      return {};
    }
  }
  return "expected the line that ends with \"start\", but the recording ends before it";
}

/// Reads a configuration as the recorded gateway did. Nothing if it is not valid here; `error` says
/// why.
std::optional<gateway::Settings> load(const std::vector<report::ConfigFile>& files,
                                      const config::ProfileSearch& search, std::string& error) {
  if (files.empty()) {
    error = "expected a configuration before the new settings";
    return std::nullopt;
  }
  std::vector<config::TextFile> read;
  read.reserve(files.size());
  for (const auto& file : files) {
    read.push_back({file.path, file.text});
  }
  auto loaded = config::load_settings(read, search);
  if (!loaded.settings) {
    error = "expected a configuration that this version accepts, but:\n" +
            config::render(loaded.diagnostics);
    error.pop_back();
  }
  return std::move(loaded.settings);
}

/// Does the input name a bus and a listener that there are?
bool fits(const gateway::Settings& settings, const gateway::Input& input) {
  return std::visit(
      [&](const auto& what) {
        if constexpr (requires { what.bus; }) {
          return static_cast<std::size_t>(what.bus) < settings.buses.size();
        } else if constexpr (requires { what.info; }) {
          return static_cast<std::size_t>(what.info.listener) < settings.listeners.size();
        } else {
          return true;
        }
      },
      input);
}

class Player {
 public:
  Player(gateway::Settings settings, gateway::Instant start, const config::ProfileSearch& search,
         ReplayOutcome& outcome)
      : gateway_(std::move(settings), start), at_(start), search_(search), outcome_(outcome) {}

  /// What is wrong with the line, or nothing. A difference is put into the outcome.
  std::string play(const RecordedLines& lines) {
    if (!report::is_action_line(lines.line())) {
      return feed(lines);
    }
    compare(lines);
    return {};
  }
  /// Nothing may be left to do for a gateway that said that it had finished.
  void play_end(const RecordedLines& lines) {
    if (finished_) {
      expect_nothing_more(lines);
    }
  }

 private:
  bool expect_nothing_more(const RecordedLines& lines) {
    const auto action = gateway_.poll_action();
    if (action) {
      outcome_.difference = {lines.number(), input_, "nothing more", text_of(*action)};
    }
    return !action;
  }
  std::string feed(const RecordedLines& lines) {
    const std::string& line = lines.line();
    if (config_.read(line)) {
      return {};
    }
    const auto recorded = report::parse_line(line, storage_);
    if (!recorded) {
      return recorded.error();
    }
    if (std::string error = wrong_instant(recorded->at, at_); !error.empty()) {
      return error;
    }
    if (!fits(gateway_.settings(), recorded->input)) {
      return fmt::format(
          "expected a bus or a listener that the recorded configuration has, found \"{}\"", line);
    }
    // What older settings have decided is carried out before newer ones: else it is not this
    // gateway that was recorded.
    const bool is_change = std::holds_alternative<gateway::SettingsChanged>(recorded->input);
    if (is_change && !expect_nothing_more(lines)) {
      return {};
    }
    at_ = recorded->at;
    input_ = line;
    ++outcome_.inputs;
    if (is_change) {
      return change_settings();
    }
    gateway_.handle(recorded->input, at_);
    return {};
  }
  std::string change_settings() {
    std::string error;
    if (const auto settings = load(config_.take(), search_, error)) {
      gateway_.handle(gateway::SettingsChanged{&*settings}, at_);
    }
    return error;
  }
  void compare(const RecordedLines& lines) {
    const auto action = gateway_.poll_action();
    const std::string replayed = action ? text_of(*action) : "nothing";
    if (replayed != lines.line()) {
      outcome_.difference = {lines.number(), input_, lines.line(), replayed};
      return;
    }
    ++outcome_.actions;
    finished_ = finished_ || std::holds_alternative<gateway::Finished>(*action);
  }
  std::string text_of(const gateway::Action& action) {
    std::string text;
    report::append_line(text, action, gateway_.settings());
    text.pop_back();
    return text;
  }
  Gateway gateway_;
  gateway::Instant at_;  // of the last input
  const config::ProfileSearch& search_;
  ReplayOutcome& outcome_;
  report::ConfigReader config_;  // of the settings that come next
  std::vector<std::uint8_t> storage_;
  std::string input_;
  bool finished_ = false;
};

/// What is wrong with the line that was read last, or nothing.
std::string play_all(RecordedLines& lines, const std::optional<std::filesystem::path>& profiles,
                     ReplayOutcome& outcome) {
  report::HeadReader reader;
  std::string error = read_head(lines, reader);
  if (!error.empty()) {
    return error;
  }
  const report::RecordingHead& head = reader.head();
  error = wrong_instant(head.start, gateway::Instant{});
  if (!error.empty()) {
    return error;
  }
  outcome.version = head.version;
  config::ProfileSearch search{profiles};
  if (!profiles && !head.profiles.empty()) {
    search.folder = head.profiles;
  }
  auto settings = load(head.config, search, error);
  if (!settings) {
    return error;
  }
  Player player(*std::move(settings), head.start, search, outcome);
  while (error.empty() && !outcome.difference && lines.next()) {
    if (report::is_end_line(lines.line())) {
      outcome.ended = lines.line().substr(4);
      return {};
    }
    error = player.play(lines);
  }
  if (error.empty() && !outcome.difference) {
    player.play_end(lines);
  }
  return error;
}

}  // namespace

ReplayOutcome replay(std::istream& recording,
                     const std::optional<std::filesystem::path>& profiles) {
  ReplayOutcome outcome;
  RecordedLines lines(recording);
  std::string error = play_all(lines, profiles, outcome);
  if (!error.empty()) {
    outcome.bad = BadRecording{lines.number(), std::move(error)};
  }
  return outcome;
}

}  // namespace mbgate::ctl
