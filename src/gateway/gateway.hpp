// SPDX-License-Identifier: Apache-2.0
// The whole gateway without its wires: bytes, line states and `now` go in, actions come out.
// After every handle() the driver empties poll_action() and re-arms next_wake().
// Single-threaded; no clock, socket, log or random source inside. Spurious and late calls are
// harmless.
//
// To change
// - the order in which actions are handed out: lines before clients: Gateway::poll_action().
// - which action or report a decision of a bus becomes: lines.
#pragma once

#include <optional>

#include "gateway/clients/clients.hpp"
#include "gateway/input.hpp"
#include "gateway/lines.hpp"
#include "gateway/status/status_report.hpp"
#include "gateway/trace/trace_book.hpp"

namespace mbgate::gateway {

/// A summary for status lines.
struct Status {
  std::size_t clients = 0;
  std::size_t buses_open = 0;
};

class Gateway {
 public:
  /// Asks for every line to be opened. The settings must be consistent: every bus that is named
  /// exists.
  Gateway(Settings settings, Instant now);

  /// The only entry point for inputs.
  void handle(const Input& input, Instant now);

  /// The next action, or nothing. Actions for lines come first: a line must not wait while sockets
  /// are written.
  std::optional<Action> poll_action();
  [[nodiscard]] std::optional<Wake> next_wake() const;

  [[nodiscard]] const Settings& settings() const { return settings_.settings(); }
  [[nodiscard]] Status status() const { return {clients_.sessions().size(), buses_.open_count()}; }
  /// False if what was to be decided at an instant has not been for kOverdue: the driver hangs, or
  /// has forgotten it.
  [[nodiscard]] bool meets_deadlines(Instant now) const;
  /// Everything that is known of buses, devices and clients.
  [[nodiscard]] StatusReport report_status(Duration uptime, Instant now,
                                           bool with_clients = true) const;
  /// While it is on, take_trace() has what became of each request. It changes no decision, and is
  /// no input: a recording knows nothing of it.
  void set_traced(bool traced);
  [[nodiscard]] TraceBook::Taken take_trace(Instant now) { return trace_.take(now); }
  /// The line is open, or it is a connection that is opened with the next request.
  [[nodiscard]] bool is_open(BusId bus) const { return buses_[bus].link().serves(); }

 private:
  void on(const DeadlineReached& input, Instant now);
  void on(const SettingsChanged& input, Instant now);
  void on(const Stalled& input, Instant now);
  void on(const ClearCountersAsked& input, Instant now);
  void on(const ShutdownAsked& input, Instant now);
  void settle(Instant now);
  bool settle_one(Instant now);

  ActionQueue actions_;
  SettingsHistory settings_;
  TraceBook trace_{settings_};
  Exchanges exchanges_;  // its jobs outlive the queues that link them
  BusSet buses_;
  WriteRules rules_;
  FailsafeWrites failsafe_;
  Lines lines_;
  Clients clients_;
  bool stopping_ = false;
  bool finished_ = false;
  std::optional<Instant> stop_deadline_;
};

}  // namespace mbgate::gateway
