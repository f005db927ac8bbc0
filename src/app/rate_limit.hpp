// SPDX-License-Identifier: Apache-2.0
// Limits the log lines of one kind: a peer or an adapter that fails again and again must not fill
// the journal. Pure: the time is handed in.
#pragma once

#include <cstddef>
#include <map>
#include <string>

#include "bus/instant.hpp"

namespace mbgate::app {

class RateLimit {
 public:
  static constexpr std::size_t kLinesPerWindow = 10;
  static constexpr bus::Duration kWindow = std::chrono::minutes(1);

  struct Verdict {
    bool write = false;
    /// This line is the last one of its kind before a silence; it should say so.
    bool last = false;
    /// Lines of this kind that were left out since the last one written.
    std::size_t left_out = 0;
  };

  /// Counts one line of a kind. Kinds are few: an event and the bus or listener it belongs to.
  Verdict count(const std::string& kind, bus::Instant now);

 private:
  struct Window {
    bus::Instant begin;
    std::size_t lines = 0;
    std::size_t left_out = 0;
  };
  std::map<std::string, Window> windows_;
};

}  // namespace mbgate::app
