// SPDX-License-Identifier: Apache-2.0
// How long a device takes to answer, and how late its answers can be: learned from those that come,
// and forgotten again.
#pragma once

#include <algorithm>

#include "bus/instant.hpp"

namespace mbgate::bus {

class AnswerPace {
 public:
  /// An answer came; `took`: from the end of the transmission. If it may also be the answer to an
  /// earlier transmission, `or_took` is the time from the end of that one, and counts unless the
  /// device is known to answer as fast as `took`. True: it came clearly sooner than any other
  /// answer of the last minute.
  bool note_answer(Duration took, Duration or_took, Instant now);
  /// A late answer came, which a quarantine as long as this would have covered.
  void note_late(Duration covering, Instant now);

  /// The longest that an answer took in the last minute, and in the one before.
  [[nodiscard]] Duration longest_answer() const {
    return std::max(longest_answer_, longest_before_);
  }
  /// How long a quarantine must be to cover what was seen of late answers. It shrinks by an eighth
  /// in each minute in which none came that the rest would not cover.
  [[nodiscard]] Duration learned(Instant now) const;

 private:
  Duration longest_answer_{0};  // in this period, and in the one before
  Duration longest_before_{0};
  Duration shortest_answer_ = Duration::max();
  Duration shortest_before_ = Duration::max();
  Instant while_began_;
  Duration learned_{0};
  Instant learned_at_ = Instant::min();
};

}  // namespace mbgate::bus
