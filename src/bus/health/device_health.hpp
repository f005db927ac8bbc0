// SPDX-License-Identifier: Apache-2.0
// Whether a device answers, and which late answers may still come from it.
//
// A transmission that timed out may still be answered late: the device *owes* an answer. That
// answer could be mistaken for the answer to a later request. Therefore the device is held in
// quarantine until all owed answers have come, or until the quarantine has passed since the
// response timeout of the last unanswered transmission. Once the device has answered something
// since then, only requests with the function code of an unanswered one are held back. The answer
// to another function, exceptions included, carries that function code and cannot be mistaken.
//
// An owed answer that does come shows how late answers can be. The quarantine then grows to cover
// it. It shrinks again by an eighth in each minute without another about as late.
//
// After `offline_after` unanswered transmissions in a row a device is offline. From then on only a
// probe is sent to it now and then, until it answers.
#pragma once

#include <bitset>
#include <optional>
#include <vector>

#include "bus/health/answer_pace.hpp"
#include "bus/health/device_state.hpp"
#include "bus/instant.hpp"
#include "bus/state_reader.hpp"
#include "drive/device.hpp"

namespace mbgate::bus {

/// The most different unanswered requests that are remembered one by one.
inline constexpr std::size_t kMostOwed = 8;

/// Added to every time for which a device is held back: an adapter may keep received bytes for this
/// long.
inline constexpr Duration kAdapterKeeps = std::chrono::milliseconds(20);

class DeviceHealth {
 public:
  using Timing = drive::DeviceTiming;

  /// The transmission of `asked` at `sent` got no answer. `due`: when its response timeout ended,
  /// or would have ended. Returns true if this takes the device offline. It does not if the device
  /// has answered, in time, something that was sent to it later.
  bool note_unanswered(const modbus::Request& asked, Instant sent, Instant due,
                       const Timing& timing);
  /// The same, where it says nothing about whether the device is there: the line was lost before an
  /// answer came.
  void note_spoilt(const modbus::Request& asked, Instant due) { owe(asked, due); }
  /// The same: an answer came with a wrong CRC or LRC.
  void note_damaged(const modbus::Request& asked, Instant due, Instant now);
  /// Another device is at this address now. What decides stays: the owed answers and the row of
  /// unanswered transmissions; and the state, as long as it is offline, because that is how
  /// requests to this address are treated.
  void forget_shown();
  struct Answered {
    const modbus::Request& asked;
    modbus::Bytes response;  ///< its PDU
    Instant sent;
    Instant due;    ///< when the response timeout would have ended
    Duration took;  ///< from the end of the transmission
  };
  /// A transmission was answered. If the answer also fits an earlier, unanswered request, it cannot
  /// be known which of the two it answers; the answer to the other one may come until after `due`.
  /// Returns true if the device was offline, and answers again and is back.
  bool note_answered(const Answered& answered, Instant now);
  /// A request is sent to the device. Owed answers that hold back no request any more are given up.
  void note_asked(Instant now, const Timing& timing);
  /// A write that is not a stop is sent to the device. From now on the answer to an earlier request
  /// no longer proves that the same request, sent after this write, was carried out.
  void note_written();
  /// What an unexpected frame shows.
  struct Late {
    Duration lateness;
    bool grew;  ///< the frame has lengthened the quarantine
    bool back;  ///< the device was offline
  };
  /// An unexpected frame of the device has come. Returns nothing if it fits no request that the
  /// device owes an answer to: then it proves nothing.
  std::optional<Late> note_unexpected(modbus::Bytes response, Instant now, const Timing& timing);

  /// How many answers to requests of this function may still be outstanding.
  [[nodiscard]] unsigned owed(std::uint8_t function, Instant now, const Timing& timing) const;
  /// How many of these look the same as the answer to this write, and do not prove that it was
  /// done. They answer a different write (the answer to 15 and 16 contains no value), or the same
  /// one sent before some other write.
  [[nodiscard]] unsigned owed_alike(const modbus::Request& write, Instant now,
                                    const Timing& timing) const;
  /// The earliest instant at which a request with this function code may be sent to the device. A
  /// stop, and the same read once more, need not wait.
  [[nodiscard]] Instant held_until(std::uint8_t function, const Timing& timing) const;
  /// The instant from which on any request may be sent.
  [[nodiscard]] Instant held_until(const Timing& timing) const;
  /// The same if no answer comes to one more, which was due then.
  [[nodiscard]] Instant held_if_unanswered(Instant due, const Timing& timing) const;
  /// The quarantine in force at `now`.
  [[nodiscard]] Duration quarantine(Instant now, const Timing& timing) const;

  [[nodiscard]] DeviceState state() const { return state_.state(); }
  /// When it began: when it was noticed or, if an answer did not come, when that was due, which may
  /// be a little later than now. Instant::min(): nothing is known of the device.
  [[nodiscard]] Instant state_since() const { return state_.since(); }
  [[nodiscard]] bool is_offline() const { return state() == DeviceState::offline; }
  [[nodiscard]] unsigned unanswered_in_row() const { return unanswered_in_row_; }
  /// When the next probe may be sent.
  [[nodiscard]] Instant probe_at() const { return probe_at_; }
  void set_probe_at(Instant instant) { probe_at_ = instant; }
  /// When a request was last refused because the device is offline.
  [[nodiscard]] Instant wanted_at() const { return wanted_at_; }
  void set_wanted_at(Instant instant) { wanted_at_ = instant; }

 private:
  friend struct mbgate::StateReader;
  /// Owed answers to the transmissions of one request.
  struct Debt {
    modbus::Request asked;
    unsigned count;
    Instant due;       ///< of the oldest
    Instant last_due;  ///< of the newest
    /// How late one of them was, if another one comes too.
    Duration suspected{0};
    bool given_up = false;  ///< holds nothing back, but an answer to it still proves lateness
    bool outdated = false;  ///< another write has gone to the device since
    bool doubtful = false;  ///< given up, and a frame that fits it was taken for another answer
    /// The end of the response timeout of the oldest transmission whose answer is not `longest`
    /// late already.
    [[nodiscard]] Instant due_at(Instant now, Duration longest) const {
      return now > due + longest ? last_due : due;
    }
  };

  Debt& owe(const modbus::Request& asked, Instant due);
  bool answer_seen(Instant now);
  [[nodiscard]] Instant end_of(const Debt& debt, const Timing& timing) const;

  std::vector<Debt> debts_;               // oldest first
  std::optional<Instant> forgotten_due_;  // of an owed answer for which there was no room
  std::bitset<256> forgotten_;            // function codes of such answers
  /// The last answer since the last unanswered transmission; none if there was no answer since.
  std::optional<Instant> answered_at_;
  AnswerPace pace_;

  unsigned unanswered_in_row_ = 0;  // sent after the last transmission that was answered
  Instant answered_sent_ = Instant::min();
  unsigned damaged_in_row_ = 0;  // shown only
  LastingState state_;
  Instant probe_at_ = Instant::min();
  Instant wanted_at_ = Instant::min();
};

}  // namespace mbgate::bus
