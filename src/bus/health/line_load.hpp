// SPDX-License-Identifier: Apache-2.0
// How busy a line is: the share of time in which something was transmitted, an answer was waited
// for, or the silence after it ran; and how many requests waited for it for long.
#pragma once

#include <optional>

#include "bus/instant.hpp"

namespace mbgate::bus {

/// A client notices it if a request waits for so long before it is sent.
inline constexpr Duration kLongWait = std::chrono::milliseconds(500);

/// Requests that were sent for the first time, and how many of them waited for kLongWait or longer.
struct LineWaits {
  unsigned all = 0;
  unsigned are_long = 0;
};

class LineLoad {
 public:
  /// Is a transmission under way at `now`? If none is, the line can be used again at `free_at`.
  void note(bool is_busy, Instant now, Instant free_at);
  /// A request is sent for the first time, and has waited for the line so long.
  void note_wait(Duration waited, Instant now);
  [[nodiscard]] bool is_busy() const { return busy_since_.has_value(); }
  /// How long it was busy in all.
  [[nodiscard]] Duration total(Instant now) const;
  /// Of the last ten seconds that are over, or of the time since the first transmission if that is
  /// less.
  [[nodiscard]] unsigned percent(Instant now) const;
  /// Of the same time.
  [[nodiscard]] LineWaits waits(Instant now) const;

 private:
  void go_on(Instant now);
  void end_busy(Instant at);

  std::optional<Instant> window_began_;  // nothing was transmitted yet
  std::optional<Instant> busy_since_;    // or later, if the time until then counts already
  Instant counted_until_ = Instant::min();
  Duration total_{0};                 // without the time since busy_since_
  Duration busy_{0};                  // in this window
  std::optional<Duration> before_{};  // in the one before
  LineWaits waits_;                   // the same of these
  LineWaits waits_before_;
};

}  // namespace mbgate::bus
