// SPDX-License-Identifier: Apache-2.0
// What was sent last, so that no class has the bus for itself.
#pragma once

#include <cstdint>
#include <optional>

#include "bus/instant.hpp"
#include "bus/job.hpp"

namespace mbgate::bus {

class TurnBook {
 public:
  void note(JobClass job_class, std::uint8_t address) {
    last_stop_ = job_class == JobClass::stop ? std::optional(address) : std::nullopt;
    writes_in_row_ = job_class == JobClass::read ? 0 : writes_in_row_ + 1;
  }
  /// A transmission has ended, with an answer or without.
  void note_end(Instant now) { last_end_ = now; }
  /// Since then nothing is on the wire, or something that was sent later.
  [[nodiscard]] Instant last_end() const { return last_end_; }
  /// The address of the last transmission, if that was a stop.
  [[nodiscard]] std::optional<std::uint8_t> last_stop() const { return last_stop_; }
  /// Writes transmitted since the last read, stops included.
  [[nodiscard]] unsigned writes_in_row() const { return writes_in_row_; }

 private:
  unsigned writes_in_row_ = 0;
  std::optional<std::uint8_t> last_stop_;
  Instant last_end_;
};

}  // namespace mbgate::bus
