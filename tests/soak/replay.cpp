// SPDX-License-Identifier: Apache-2.0
#include "soak/replay.hpp"

#include <utility>
#include <vector>

#include "config/load.hpp"
#include "gateway/gateway.hpp"
#include "gateway/recording/record.hpp"

namespace mbgate::test {
namespace {

using gateway::Gateway;

/// The lines of the recording, counted.
class Lines {
 public:
  explicit Lines(std::istream& stream) : stream_(stream) {}
  /// False at the end; a last line without its newline was cut off, and does not count.
  bool next() {
    ++number_;
    return std::getline(stream_, line_) && !stream_.eof();
  }
  [[nodiscard]] const std::string& line() const { return line_; }
  [[nodiscard]] std::string at(const std::string& text) const {
    return "line " + std::to_string(number_) + ": " + text;
  }

 private:
  std::istream& stream_;
  std::string line_;
  std::size_t number_ = 0;
};

/// What is wrong with the head, or nothing.
std::string read_head(Lines& lines, gateway::HeadReader& reader) {
  while (lines.next()) {
    const auto complete = reader.read(lines.line());
    if (!complete) {
      return lines.at(complete.error());
    }
    if (*complete) {
      return {};
    }
  }
  return "the recording ends before the gateway started";
}

/// Reads configurations as the recorded gateway did.
class Loader {
 public:
  Loader(const gateway::RecordingHead& head, std::optional<std::filesystem::path> profiles) {
    search_.folder = std::move(profiles);
    if (!search_.folder && !head.profiles.empty()) {
      search_.folder = head.profiles;
    }
  }
  /// Nothing if it is not valid here; `error` says why.
  [[nodiscard]] std::optional<gateway::Settings> load(const std::vector<gateway::ConfigFile>& files,
                                                      std::string& error) const {
    if (files.empty()) {
      error = "no configuration stands before other settings";
      return std::nullopt;
    }
    std::vector<config::TextFile> read;
    for (const auto& file : files) {
      read.push_back({file.path, file.text});
    }
    auto loaded = config::load_settings(read, search_);
    if (!loaded.settings) {
      error =
          "the recorded configuration is not valid here:\n" + config::render(loaded.diagnostics);
    }
    return std::move(loaded.settings);
  }

 private:
  config::ProfileSearch search_;
};

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
  Player(gateway::Settings settings, gateway::Instant start, const Loader& loader,
         ReplayOutcome& outcome)
      : gateway_(std::move(settings), start), loader_(loader), outcome_(outcome) {}

  /// What is wrong with the line, or nothing.
  std::string play(const std::string& line) {
    return gateway::is_action_line(line) ? compare(line) : feed(line);
  }
  /// Nothing may be left to do for a gateway that said that it had finished.
  std::string play_end() {
    const auto action = finished_ ? gateway_.poll_action() : std::nullopt;
    return action ? "the recording ends here, the replay gives \"" + text_of(*action) + '"' : "";
  }

 private:
  std::string feed(const std::string& line) {
    if (config_.read(line)) {
      return {};
    }
    const auto recorded = gateway::parse_line(line, storage_);
    if (!recorded) {
      return recorded.error();
    }
    if (!fits(gateway_.settings(), recorded->input)) {
      return "the configuration has no such bus or listener: \"" + line + '"';
    }
    ++outcome_.inputs;
    if (std::holds_alternative<gateway::SettingsChanged>(recorded->input)) {
      return change_settings(recorded->at);
    }
    gateway_.handle(recorded->input, recorded->at);
    return {};
  }
  std::string change_settings(gateway::Instant at) {
    std::string error;
    if (const auto settings = loader_.load(config_.take(), error)) {
      gateway_.handle(gateway::SettingsChanged{&*settings}, at);
    }
    return error;
  }
  std::string compare(const std::string& line) {
    ++outcome_.actions;
    const auto action = gateway_.poll_action();
    const std::string replayed = action ? text_of(*action) : "nothing";
    finished_ = finished_ || (action && std::holds_alternative<gateway::Finished>(*action));
    return replayed == line ? ""
                            : "recorded \"" + line + "\", the replay gives \"" + replayed + '"';
  }
  std::string text_of(const gateway::Action& action) {
    std::string text;
    gateway::append_line(text, action, gateway_.settings());
    text.pop_back();
    return text;
  }

  Gateway gateway_;
  const Loader& loader_;
  ReplayOutcome& outcome_;
  gateway::ConfigReader config_;  // of the settings that come next
  std::vector<std::uint8_t> storage_;
  bool finished_ = false;
};

}  // namespace

ReplayOutcome replay(std::istream& recording,
                     const std::optional<std::filesystem::path>& profiles) {
  ReplayOutcome outcome;
  Lines lines(recording);
  gateway::HeadReader reader;
  outcome.difference = read_head(lines, reader);
  if (!outcome.difference.empty()) {
    return outcome;
  }
  const gateway::RecordingHead& head = reader.head();
  outcome.version = head.version;
  const Loader loader(head, profiles);
  auto settings = loader.load(head.config, outcome.difference);
  if (!settings) {
    return outcome;
  }
  Player player(*std::move(settings), head.start, loader, outcome);
  while (outcome.difference.empty() && lines.next()) {
    if (gateway::is_end_line(lines.line())) {
      outcome.ended = lines.line().substr(4);
      return outcome;
    }
    outcome.difference = player.play(lines.line());
  }
  if (outcome.difference.empty()) {
    outcome.difference = player.play_end();
  }
  if (!outcome.difference.empty()) {
    outcome.difference = lines.at(outcome.difference);
  }
  return outcome;
}

std::string to_text(const ReplayOutcome& outcome) {
  if (!outcome.difference.empty()) {
    return "different: " + outcome.difference;
  }
  return "identical: " + std::to_string(outcome.inputs) + " inputs, " +
         std::to_string(outcome.actions) + " actions, recorded by mbgated " + outcome.version +
         (outcome.ended.empty() ? "" : "; the recording ended: " + outcome.ended);
}

}  // namespace mbgate::test
