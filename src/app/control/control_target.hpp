// SPDX-License-Identifier: Apache-2.0
// The questions and commands of the control socket that the gateway's thread answers.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "app/control/asker.hpp"
#include "app/metrics/metrics.hpp"
#include "gateway/trace/trace_book.hpp"

namespace mbgate::app {

/// The result of a reload.
struct ReloadOutcome {
  bool done = false;
  std::vector<std::string> messages;  ///< what has changed, or why it was refused
};

/// Answers on the gateway's thread.
class ControlTarget {
 public:
  using ReloadEnded = std::function<void(const ReloadOutcome&)>;

  virtual ~ControlTarget() = default;
  [[nodiscard]] virtual gateway::StatusReport report_status(bool with_clients) const = 0;
  [[nodiscard]] virtual ProcessStatus process_status() const = 0;
  /// Is every bus looked at when it is time?
  [[nodiscard]] virtual bool meets_deadlines() const = 0;
  /// `ended` is called once, on the same thread, perhaps at once.
  virtual void reload(const Asker& asker, ReloadEnded ended) = 0;
  virtual void clear_counters(const Asker& asker) = 0;
  /// A command over the Unix socket was refused, or has failed; `what` says which, and why.
  virtual void command_denied(const Asker& asker, const std::string& what) = 0;
  /// While it is on, take_trace() has what became of each request since the last call.
  virtual void set_traced(bool traced) = 0;
  virtual gateway::TraceBook::Taken take_trace() = 0;
  /// A connection has ended because of a fault of the interface.
  virtual void control_failed(const std::string& why) = 0;
  /// A client of this address was refused over TCP.
  virtual void http_refused(const std::string& address) = 0;
};

}  // namespace mbgate::app
