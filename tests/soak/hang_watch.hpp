// SPDX-License-Identifier: Apache-2.0
// A serial line from which nothing comes must be opened again: not before it was silent for
// `hung_after`, doubled each time in vain up to `hung_max`, and so many requests left; then before
// anything else is transmitted. The first time it is told.
#pragma once

#include <vector>

#include "soak/flight.hpp"

namespace mbgate::soak {

class HangWatch {
 public:
  explicit HangWatch(const SoakPlan& plan) : plan_(plan), lines_(plan.settings.buses.size()) {}

  /// The process has opened the line, or has read from it.
  void opened(std::size_t bus, Instant now);
  void read(std::size_t bus, Instant now);
  /// Another line, or another bus.
  void forget(std::size_t bus) { lines_[bus] = {}; }
  /// The gateway transmits. What it has missed; empty if nothing.
  std::string transmitted(const Flight& flight);
  /// It opens the line again. Why it must not.
  std::string restarted(std::size_t bus, Instant now);
  /// It says so. Why it must not.
  std::string told(std::size_t bus);
  /// May it do so now?
  [[nodiscard]] bool is_due(std::size_t bus, Instant now) const;

 private:
  struct Line {
    Instant heard = Instant::min();  ///< anything, or it was opened
    unsigned left = 0;               ///< requests since then, at most
    unsigned asked = 0;              ///< that surely are to be answered
    unsigned in_vain = 0;            ///< times that it was opened since anything was heard
    bool must_tell = false;
    bool was_stop = false;  ///< what was sent last
  };
  [[nodiscard]] bool is_silent_for_long(std::size_t bus, Instant now) const;

  const SoakPlan& plan_;
  std::vector<Line> lines_;
};

}  // namespace mbgate::soak
