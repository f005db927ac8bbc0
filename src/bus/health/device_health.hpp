// SPDX-License-Identifier: Apache-2.0
// Whether a device answers.
//
// After `offline_after` unanswered transmissions in a row a device is offline. From then on only a
// probe is sent to it now and then, until it answers.
#pragma once

#include <algorithm>
#include <cstdint>
#include <utility>

#include "bus/instant.hpp"

namespace mbgate::bus {

// How a device is, and since when, as those who ask are told. Counters may be cleared; this stays.

/// The numbers are those of the registers of unit 255.
enum class DeviceState : std::uint8_t {
  not_asked = 0,      ///< nothing was sent to it
  answering = 1,      ///< it has answered the last request, perhaps late
  not_answering = 2,  ///< it has not
  offline = 3,        ///< it has not answered for so long that it is only probed
  damaged = 4,        ///< its last answers had a bad CRC or LRC
  line_not_open = 5   ///< it was answering when its line was lost (Parts::state_of)
};

class DeviceHealth {
 public:
  /// The transmission at `sent` got no answer. `due`: when its response timeout ended, or would
  /// have ended. Returns true if this takes the device offline, as the last of `offline_after` (0:
  /// never). It does not if the device has answered, in time, something that was sent to it later.
  bool note_unanswered(Instant sent, Instant due, unsigned offline_after) {
    if (sent <= answered_sent_) {
      return false;
    }
    ++unanswered_in_row_;
    if (is_offline()) {
      return false;
    }
    const bool is_lost = offline_after != 0 && unanswered_in_row_ >= offline_after;
    enter(is_lost ? DeviceState::offline : DeviceState::not_answering, due);
    return is_lost;
  }
  /// An answer came with a wrong CRC or LRC, or fits in nothing else.
  void note_damaged(Instant now) {
    const bool was_well = state() == DeviceState::answering && ++damaged_in_row_ < kDamagedInRow;
    if (!is_offline() && !was_well) {
      enter(DeviceState::damaged, now);
    }
  }
  /// The transmission at `sent` was answered; note_heard() follows.
  void note_answered(Instant sent) { answered_sent_ = std::max(answered_sent_, sent); }
  /// A good frame of the device came, however late. Returns true if the device was offline, and is
  /// back.
  bool note_heard(Instant now) {
    unanswered_in_row_ = damaged_in_row_ = 0;
    return enter(DeviceState::answering, now) == DeviceState::offline;
  }
  /// Another device is at this address now. What decides stays: the row of unanswered
  /// transmissions; and the state, as long as it is offline, because that is how requests to this
  /// address are treated.
  void forget_shown() {
    if (!is_offline()) {
      state_ = DeviceState::not_asked;
      since_ = Instant::min();
    }
  }

  [[nodiscard]] DeviceState state() const { return state_; }
  /// When it began: when it was noticed or, if an answer did not come, when that was due, which may
  /// be a little later than now. Instant::min(): nothing is known of the device.
  [[nodiscard]] Instant state_since() const { return since_; }
  [[nodiscard]] bool is_offline() const { return state() == DeviceState::offline; }
  [[nodiscard]] unsigned unanswered_in_row() const { return unanswered_in_row_; }
  /// Its last transmission is unanswered, the one before was answered.
  [[nodiscard]] bool answered_before_last() const {
    return unanswered_in_row_ == 1 && answered_sent_ != Instant::min();
  }

 private:
  static constexpr unsigned kDamagedInRow = 3;  // of a device that answers, before it is shown

  /// Returns the state that it was in.
  DeviceState enter(DeviceState state, Instant at) {
    since_ = state != state_ ? at : since_;
    return std::exchange(state_, state);
  }

  unsigned unanswered_in_row_ = 0;  // sent after the last transmission that was answered
  Instant answered_sent_ = Instant::min();
  unsigned damaged_in_row_ = 0;  // shown only
  DeviceState state_ = DeviceState::not_asked;
  Instant since_ = Instant::min();
};

// How long nothing has come from a device, as it is shown. It decides nothing: what takes a device
// offline is counted in DeviceHealth, where a damaged answer ends no row.

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
