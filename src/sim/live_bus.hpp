// SPDX-License-Identifier: Apache-2.0
// A virtual bus on a pty: what comes out of the pty goes onto the wire, what the wire delivers goes
// into it. Part of the simulator's shell; the instants are those of the steady clock.
#pragma once

#include <optional>
#include <string>

#include "sim/pty.hpp"
#include "sim/request_framer.hpp"
#include "sim/settings.hpp"
#include "sim/wire.hpp"

namespace mbgate::sim {

class LiveBus {
 public:
  explicit LiveBus(const BusSettings& settings);

  /// Makes pty and link; an error text if that fails.
  std::optional<std::string> connect();
  /// The adapter vanishes; the drives keep their state.
  void disconnect();
  /// The connected pty, nullptr if there is none.
  [[nodiscard]] const Pty* pty() const { return pty_ ? &*pty_ : nullptr; }

  void handle_readable(Instant now);
  void handle_time(Instant now);
  [[nodiscard]] std::optional<Instant> next_event() const;

  /// "bus line-a ./line-a (/dev/pts/7)".
  [[nodiscard]] std::string introduction() const;
  /// "bus line-a: frames 3, answers 3, silence violations 0, collisions 0, bad CRC 0".
  [[nodiscard]] std::string counters_text() const;

 private:
  std::string name_;
  std::filesystem::path link_;
  RequestFramer framer_;
  Wire wire_;
  std::optional<Pty> pty_;
};

}  // namespace mbgate::sim
