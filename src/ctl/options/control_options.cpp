// SPDX-License-Identifier: Apache-2.0
#include "ctl/options/control_options.hpp"

#include <CLI/CLI.hpp>

#include "ctl/options/server_options.hpp"

namespace mbgate::ctl {
namespace {

// A status has every device and client in it: it is not asked for as often as a register may be.
constexpr std::chrono::milliseconds kShortestPeriodOfStatus{100};
constexpr unsigned kMostStatuses = 1'000'000'000;

}  // namespace

void add_control(CLI::App& command, std::string& socket) {
  command
      .add_option("--control", socket,
                  "the control socket of mbgated, its [http] socket; or, to read, "
                  "tcp://HOST:PORT, one of its [http] listen")
      ->type_name("PLACE")
      ->capture_default_str();
}

StatusOptions::StatusOptions(CLI::App& app)
    : status_(app.add_subcommand(
          "status",
          "Show how a running mbgated, its lines and its drives are: what is not well first.")) {
  auto* watch = status_->add_flag(
      "--watch", watch_,
      "show it again and again, on a terminal in place, until q is typed or it is interrupted");
  status_->add_option("--every", every_, "with --watch: how often, from start to start")
      ->needs(watch)
      ->capture_default_str();
  status_->add_option("--times", words_.times, "with --watch: end after so many times")
      ->needs(watch)
      ->check(CLI::Range(1U, kMostStatuses));
  status_->add_flag("--json", words_.json, "for programs: one JSON object a line");
  add_control(*status_, words_.socket);
}

bool StatusOptions::given() const { return status_->parsed(); }

Result<Command, std::string> StatusOptions::command() const {
  StatusCommand status = words_;
  if (watch_) {
    const auto every = parse_time(every_, kShortestPeriodOfStatus);
    if (!every) {
      return every.error();
    }
    status.every = *every;
  }
  return Command(status);
}

ReloadOptions::ReloadOptions(CLI::App& app)
    : reload_(app.add_subcommand(
          "reload",
          "Have a running mbgated read its configuration again, and say what has changed or why "
          "it was refused.")) {
  add_control(*reload_, words_.socket);
}

bool ReloadOptions::given() const { return reload_->parsed(); }

ClearCountersOptions::ClearCountersOptions(CLI::App& app)
    : clear_(app.add_subcommand(
          "clear-counters",
          "Have all counters of a running mbgated, of lines, drives and requests, begin anew.")) {
  add_control(*clear_, words_.socket);
}

bool ClearCountersOptions::given() const { return clear_->parsed(); }

EventsOptions::EventsOptions(CLI::App& app)
    : events_(app.add_subcommand(
          "events", "Print what a running mbgated writes to the journal, as it is written.")) {
  events_->add_flag("--json", words_.json, "for programs: one JSON object a line");
  add_control(*events_, words_.socket);
}

bool EventsOptions::given() const { return events_->parsed(); }

}  // namespace mbgate::ctl
