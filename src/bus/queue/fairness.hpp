// SPDX-License-Identifier: Apache-2.0
// Fairness: no class of requests has the bus for itself, and devices that do not answer take no
// more than half of its time.
#pragma once

#include <algorithm>
#include <cstdint>
#include <optional>

#include "bus/instant.hpp"
#include "bus/job.hpp"

namespace mbgate::bus {

// What was sent last, so that no class has the bus for itself.

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

// Lost time is paid back. After a transmission that nobody has answered, reads of devices that do
// not answer wait for as long again as it took, while other devices answer, and writes to them let
// other writes go first. So dead drives take half of the time of a line at most, and delay a write
// to a drive that is well by the running transaction alone.

class Payback {
 public:
  /// What was sent then has not been answered. Only the last loss is paid back.
  void note_lost(Instant sent, Instant now) { until_ = now + (now - sent); }
  [[nodiscard]] bool is_due(Instant now) const { return now < until_; }
  void note_answered(std::uint8_t address, Instant now) {
    other_answered_at_ = address == address_ ? other_answered_at_ : answered_at_;
    address_ = address;
    answered_at_ = now;
  }
  /// Until then requests to this device wait, which does not answer. `recently`: if no other device
  /// has answered for so long, nobody is there to be paid.
  [[nodiscard]] Instant until(std::uint8_t address, Duration recently) const {
    const Instant paid = address == address_ ? other_answered_at_ : answered_at_;
    return paid == Instant::min() ? paid : std::min(until_, paid + recently);
  }

 private:
  Instant until_ = Instant::min();
  std::uint8_t address_ = 0;  // of the device that answered last
  Instant answered_at_ = Instant::min();
  Instant other_answered_at_ = Instant::min();  // of the others, the last time
};

}  // namespace mbgate::bus
