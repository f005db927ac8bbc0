// SPDX-License-Identifier: Apache-2.0
// The line side: passes input of lines to their buses, and makes actions of the buses' decisions.
#pragma once

#include <optional>

#include "bus/bus_action.hpp"
#include "gateway/action.hpp"
#include "gateway/bus_set.hpp"
#include "gateway/exchanges/exchanges.hpp"
#include "gateway/input.hpp"
#include "gateway/trace/trace_book.hpp"

namespace mbgate::gateway {

class Lines {
 public:
  Lines(BusSet& buses, Exchanges& exchanges, TraceBook& trace, ActionQueue& actions)
      : buses_(buses), exchanges_(exchanges), trace_(trace), actions_(actions) {}

  /// Of a bus that is there.
  void handle(const LineOpened& input, Instant now);
  void handle(const LineBytes& input, Instant now);
  void handle(const LineUnsent& input, Instant now);
  void handle(const LineLooked& input, Instant now);
  void handle(const LineLost& input, Instant now);

  /// Carries out what a bus has decided; false if none has decided anything.
  bool serve_one(Instant now) {
    const auto bus = buses_.take_touched();
    if (bus) {
      serve(*bus, now);
    }
    return bus.has_value();
  }
  /// The next action for a line, or nothing. Reports are not among them.
  std::optional<Action> poll_action() { return line_actions_.poll(); }
  [[nodiscard]] bool has_actions() const { return !line_actions_.empty(); }

  /// New settings are in force: lines that these do not have, or have otherwise, are closed.
  void adopt(const Settings& before, const Settings& next, Instant now);

 private:
  void serve(BusId bus, Instant now);
  void carry_out(BusId bus, const bus::BusAction& action);
  void report(const Event& event) { actions_.push(Report{event}); }

  BusSet& buses_;
  Exchanges& exchanges_;
  TraceBook& trace_;
  ActionQueue& actions_;
  ActionQueue line_actions_;
};

}  // namespace mbgate::gateway
