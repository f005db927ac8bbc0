// SPDX-License-Identifier: Apache-2.0
// The simulator's process: buses on ptys and sockets, one thread, one precise timer, signals as
// input.
#pragma once

#include <iosfwd>
#include <optional>
#include <variant>
#include <vector>

#include "sim/program/live_bus.hpp"
#include "sim/program/settings.hpp"
#include "sys/unique_fd.hpp"

namespace mbgate::sim {

class Simulator {
 public:
  /// Ready lines and counters go to `output`, errors to `errors`.
  Simulator(const Settings& settings, std::ostream& output, std::ostream& errors);

  /// Serves until SIGTERM or SIGINT; SIGUSR1 prints the counters, SIGUSR2 closes the ptys and
  /// sockets for a while. The exit status: 0, or 1 if a pty, a link, a port or the system fails.
  int run();

 private:
  using AnyBus = std::variant<LiveBus, LiveTcpBus>;

  bool prepare();
  bool connect();
  void disconnect();
  void serve_once();
  void release_exclusive();
  void handle_signal();
  void print_counters();
  [[nodiscard]] std::optional<Instant> next_event() const;
  void arm_timer();
  void wait();
  void handle_timer();

  Duration reopen_after_;
  std::vector<AnyBus> buses_;
  std::ostream& output_;
  std::ostream& errors_;
  sys::UniqueFd signals_;
  sys::UniqueFd timer_;
  std::optional<Instant> armed_for_;
  std::optional<Instant> reopen_at_;
  Instant release_at_{};
  bool failed_ = false;
  bool stopping_ = false;
};

}  // namespace mbgate::sim
