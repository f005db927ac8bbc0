// SPDX-License-Identifier: Apache-2.0
// What belongs to `mbgatectl status`, `reload`, `clear-counters` and `events` on the command line.
#pragma once

#include <string>

#include "ctl/request/command.hpp"

namespace CLI {  // NOLINT(readability-identifier-naming): the library is named so
class App;
}

namespace mbgate::ctl {

/// --control: where mbgated is asked.
void add_control(CLI::App& command, std::string& socket);

class StatusOptions {
 public:
  explicit StatusOptions(CLI::App& app);
  StatusOptions(const StatusOptions&) = delete;
  StatusOptions& operator=(const StatusOptions&) = delete;

  [[nodiscard]] bool given() const;
  /// The error is a full sentence.
  [[nodiscard]] Result<Command, std::string> command() const;

 private:
  CLI::App* status_;
  StatusCommand words_;
  bool watch_ = false;
  std::string every_ = "1s";
};

class ReloadOptions {
 public:
  explicit ReloadOptions(CLI::App& app);
  ReloadOptions(const ReloadOptions&) = delete;
  ReloadOptions& operator=(const ReloadOptions&) = delete;

  [[nodiscard]] bool given() const;
  [[nodiscard]] Result<Command, std::string> command() const { return Command(words_); }

 private:
  CLI::App* reload_;
  ReloadCommand words_;
};

class ClearCountersOptions {
 public:
  explicit ClearCountersOptions(CLI::App& app);
  ClearCountersOptions(const ClearCountersOptions&) = delete;
  ClearCountersOptions& operator=(const ClearCountersOptions&) = delete;

  [[nodiscard]] bool given() const;
  [[nodiscard]] Result<Command, std::string> command() const { return Command(words_); }

 private:
  CLI::App* clear_;
  ClearCountersCommand words_;
};

class EventsOptions {
 public:
  explicit EventsOptions(CLI::App& app);
  EventsOptions(const EventsOptions&) = delete;
  EventsOptions& operator=(const EventsOptions&) = delete;

  [[nodiscard]] bool given() const;
  [[nodiscard]] Result<Command, std::string> command() const { return Command(words_); }

 private:
  CLI::App* events_;
  EventsCommand words_;
};

}  // namespace mbgate::ctl
