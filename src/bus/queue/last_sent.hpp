// SPDX-License-Identifier: Apache-2.0
// What was sent last, so that no class has the bus for itself.
#pragma once

#include <cstdint>
#include <optional>

#include "bus/instant.hpp"
#include "bus/job.hpp"

namespace mbgate::bus {

class LastSent {
 public:
  void note(JobClass job_class, std::uint8_t address) {
    stop_ = job_class == JobClass::stop ? std::optional(address) : std::nullopt;
    writes_in_row_ = job_class == JobClass::read ? 0 : writes_in_row_ + 1;
  }
  /// A transmission has ended, with an answer or without.
  void note_end(Instant now) { ended_at_ = now; }
  /// Since then nothing is on the wire, or something that was sent later.
  [[nodiscard]] Instant ended_at() const { return ended_at_; }
  /// The address of the last transmission, if that was a stop.
  [[nodiscard]] std::optional<std::uint8_t> stop() const { return stop_; }
  /// Writes transmitted since the last read, stops included.
  [[nodiscard]] unsigned writes_in_row() const { return writes_in_row_; }

 private:
  unsigned writes_in_row_ = 0;
  std::optional<std::uint8_t> stop_;
  Instant ended_at_;
};

}  // namespace mbgate::bus
