// SPDX-License-Identifier: Apache-2.0
// How long nothing has come from a device, as it is shown. It decides nothing: what takes a device
// offline is counted in DeviceHealth, where a damaged answer ends no row.
#pragma once

#include "bus/instant.hpp"

namespace mbgate::bus {

class Silence {
 public:
  /// A valid answer of the device came, late or not.
  void note_answer(Instant now) {
    last_answer_ = now;
    note_damaged(now);
  }
  /// An answer with a bad CRC or LRC came.
  void note_damaged(Instant now) {
    heard_ = now;
    transmissions_ = requests_ = 0;
  }
  /// A transmission of `sent` was left unanswered; `is_first`: it was no repetition.
  void note_unanswered(Instant sent, bool is_first) {
    if (sent >= heard_) {
      began_ = transmissions_ == 0 ? sent : began_;
      ++transmissions_;
      requests_ += is_first ? 1U : 0U;
    }
  }

  /// Sent and left unanswered since the last frame of the device.
  [[nodiscard]] unsigned transmissions() const { return transmissions_; }
  /// Of how many requests these are; one whose first transmission was damaged does not count.
  [[nodiscard]] unsigned requests() const { return requests_; }
  /// When the first of these was sent; without meaning if there is none.
  [[nodiscard]] Instant began() const { return began_; }
  /// Instant::min(): none came.
  [[nodiscard]] Instant last_answer() const { return last_answer_; }

 private:
  unsigned transmissions_ = 0;
  unsigned requests_ = 0;
  Instant began_ = Instant::min();
  Instant heard_ = Instant::min();
  Instant last_answer_ = Instant::min();
};

}  // namespace mbgate::bus
