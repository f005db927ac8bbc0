// SPDX-License-Identifier: Apache-2.0
// Lost time is paid back. After a transmission that nobody has answered, requests to devices that
// do not answer wait for as long again as it took, while other devices answer. So dead drives take
// half of the time of a line at most, and delay a write to a drive that is well by the running
// transaction alone.
#pragma once

#include <algorithm>
#include <cstdint>

#include "bus/instant.hpp"

namespace mbgate::bus {

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
