// SPDX-License-Identifier: Apache-2.0
// The order of the transmissions of a bus, kept so that no class and no device has the bus for
// itself. Each transmission has a number, its *turn*.
#pragma once

#include <cstdint>

#include "bus/instant.hpp"
#include "bus/job.hpp"

namespace mbgate::bus {

class TurnBook {
 public:
  /// A transmission is sent to the address. Returns its turn.
  std::uint64_t note(JobClass job_class, std::uint8_t address) {
    turn_of_others_ = last_address_ == address ? turn_of_others_ : turn_;
    last_address_ = address;
    ++turn_;
    other_turn_ = job_class == JobClass::stop ? other_turn_ : turn_;
    writes_in_row_ = job_class == JobClass::read ? 0 : writes_in_row_ + 1;
    return turn_;
  }
  /// A transmission has ended, with an answer or without.
  void note_end(Instant now) { last_end_ = now; }
  /// Since then nothing is on the wire, or something that was sent later.
  [[nodiscard]] Instant last_end() const { return last_end_; }
  /// The last one that was no stop.
  [[nodiscard]] std::uint64_t last_but_stops() const { return other_turn_; }
  /// Was the last one of all a stop?
  [[nodiscard]] bool was_stop_last() const { return turn_ > other_turn_; }
  /// The last turn before the latest uninterrupted run of transmissions to this address.
  [[nodiscard]] std::uint64_t last_but_to(std::uint8_t address) const {
    return last_address_ == address ? turn_of_others_ : turn_;
  }
  /// Writes transmitted since the last read, stops included.
  [[nodiscard]] unsigned writes_in_row() const { return writes_in_row_; }

 private:
  unsigned writes_in_row_ = 0;
  std::uint64_t turn_ = 0;
  std::uint64_t other_turn_ = 0;
  std::uint8_t last_address_ = 0;
  std::uint64_t turn_of_others_ = 0;
  Instant last_end_;
};

}  // namespace mbgate::bus
