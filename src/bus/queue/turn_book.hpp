// SPDX-License-Identifier: Apache-2.0
// What was sent last, so that no class has the bus for itself.
#pragma once

#include "bus/instant.hpp"
#include "bus/job.hpp"

namespace mbgate::bus {

class TurnBook {
 public:
  void note(JobClass job_class) {
    was_stop_last_ = job_class == JobClass::stop;
    writes_in_row_ = job_class == JobClass::read ? 0 : writes_in_row_ + 1;
  }
  /// A transmission has ended, with an answer or without.
  void note_end(Instant now) { last_end_ = now; }
  /// Since then nothing is on the wire, or something that was sent later.
  [[nodiscard]] Instant last_end() const { return last_end_; }
  [[nodiscard]] bool was_stop_last() const { return was_stop_last_; }
  /// Writes transmitted since the last read, stops included.
  [[nodiscard]] unsigned writes_in_row() const { return writes_in_row_; }

 private:
  unsigned writes_in_row_ = 0;
  bool was_stop_last_ = false;
  Instant last_end_;
};

}  // namespace mbgate::bus
