// SPDX-License-Identifier: Apache-2.0
// Whether a device answers, and which answers it still owes.
//
// A device owes one answer for each transmission that got none. Such an answer may still come, and
// could be taken for that to a later request; so the device is left alone until all of them were
// seen, or until its quarantine has passed since the response timeout of the last unanswered
// transmission. An answer that does come proves lateness: the quarantine then grows to cover it,
// and shrinks again by an eighth in each minute without another one.
//
// After so many unanswered transmissions in a row a device is offline; from then on only a probe
// now and then is for it, until it answers.
#pragma once

#include <boost/container/static_vector.hpp>
#include <optional>

#include "bus/instant.hpp"
#include "drive/device.hpp"

namespace mbgate::bus {

/// Unanswered transmissions whose instants are remembered; of more, only how many they were.
inline constexpr std::size_t kMostOwed = 8;

class DeviceHealth {
 public:
  using Timing = drive::DeviceTiming;

  /// A transmission got no answer; `due` is when its response timeout ended, or would have.
  /// Returns true if the device has just gone offline by that.
  bool note_unanswered(Instant due, const Timing& timing);
  /// The same, but it says nothing about whether the device is there: a frame of the right shape
  /// came with a wrong CRC, or the line was lost before an answer came.
  void note_spoilt(Instant due) { owe(due); }
  /// A transmission was answered. If an earlier one was not, nobody can tell whose answer this is,
  /// and the other one may come until after `due`, the end of this one's response timeout. Returns
  /// true if the device is back by that.
  bool note_answered(Instant due, Instant now);
  /// A request that is no repetition goes to the device: what it owed is given up.
  void note_asked();
  /// What a frame that nobody waits for tells.
  struct Late {
    Duration lateness;
    bool grew;  ///< the quarantine has become longer by it
    bool back;  ///< the device was offline
  };
  /// Such a frame of the device has come. Nothing if it owes none.
  std::optional<Late> note_unexpected(Instant now, const Timing& timing);

  /// How many answers may still be outstanding.
  [[nodiscard]] unsigned owed(Instant now, const Timing& timing) const;
  /// Nothing but a stop, or the same read once more, is sent to the device before.
  [[nodiscard]] Instant held_until(const Timing& timing) const;
  /// In force at `now`.
  [[nodiscard]] Duration quarantine(Instant now, const Timing& timing) const;

  [[nodiscard]] bool is_offline() const { return offline_; }
  [[nodiscard]] unsigned unanswered_in_row() const { return unanswered_in_row_; }
  /// When the next probe may be sent.
  [[nodiscard]] Instant probe_at() const { return probe_at_; }
  void set_probe_at(Instant instant) { probe_at_ = instant; }
  /// When a request was last refused because the device is offline.
  [[nodiscard]] Instant wanted_at() const { return wanted_at_; }
  void set_wanted_at(Instant instant) { wanted_at_ = instant; }

 private:
  void owe(Instant due);
  bool answer_seen();
  [[nodiscard]] Duration learned(Instant now) const;

  boost::container::static_vector<Instant, kMostOwed> owed_;  // when they were due, oldest first
  unsigned more_owed_ = 0;                                    // older ones
  Instant last_due_ = Instant::min();
  std::optional<Instant> given_up_;  // when the oldest answer that was given up was due
  /// An answer came late if the one that is still owed comes too.
  Duration suspected_{0};
  Duration learned_{0};
  Instant learned_at_ = Instant::min();

  unsigned unanswered_in_row_ = 0;
  bool offline_ = false;
  Instant probe_at_ = Instant::min();
  Instant wanted_at_ = Instant::min();
};

}  // namespace mbgate::bus
