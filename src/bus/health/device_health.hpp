// SPDX-License-Identifier: Apache-2.0
// Whether a device answers, and which answers it still owes.
//
// A device owes one answer for each transmission that got none. Such an answer may still come, and
// could be taken for that to a later request; so the device is left alone until all of them were
// seen, or until its quarantine has passed since the response timeout of the last unanswered
// transmission. Once it has answered since, only requests of the same function are held back: the
// answer to one of another function, exceptions included, names that function and cannot be
// mistaken. An owed answer that does come proves lateness: the quarantine then grows to cover it,
// and shrinks again by an eighth in each minute without another one.
//
// After so many unanswered transmissions in a row a device is offline; from then on only a probe
// now and then is for it, until it answers.
#pragma once

#include <bitset>
#include <optional>
#include <vector>

#include "bus/instant.hpp"
#include "bus/state_reader.hpp"
#include "drive/device.hpp"

namespace mbgate::bus {

/// Different unanswered requests that are remembered one by one.
inline constexpr std::size_t kMostOwed = 8;

/// Holds are longer by this than what they are for: an adapter may keep what it has received so
/// long.
inline constexpr Duration kAdapterKeeps = std::chrono::milliseconds(20);

class DeviceHealth {
 public:
  using Timing = drive::DeviceTiming;

  /// A transmission of `asked`, at `sent`, got no answer; `due` is when its response timeout ended,
  /// or would have. Returns true if the device has just gone offline by that: not if it has
  /// answered in time what was sent to it later.
  bool note_unanswered(const modbus::Request& asked, Instant sent, Instant due,
                       const Timing& timing);
  /// The same, but it says nothing about whether the device is there: a frame of the right shape
  /// came with a wrong CRC, or the line was lost before an answer came.
  void note_spoilt(const modbus::Request& asked, Instant due) { owe(asked, due); }
  struct Answered {
    const modbus::Request& asked;
    modbus::Bytes response;  ///< its PDU
    Instant sent;
    Instant due;    ///< when the response timeout would have ended
    Duration took;  ///< from the end of the transmission
  };
  /// A transmission was answered. If an earlier one that this answer fits was not, nobody can tell
  /// whose answer it is, and the other one may come until after `due`. Returns true if the device
  /// is back by that.
  bool note_answered(const Answered& answered, Instant now);
  /// Something goes to the device: what it owed until now, and is no reason to hold anything back
  /// any more, is given up.
  void note_asked(Instant now, const Timing& timing);
  /// A write that is no stop goes to the device: an answer to an earlier request tells nothing of
  /// the same one after it.
  void note_written();
  /// What a frame that nobody waits for tells.
  struct Late {
    Duration lateness;
    bool grew;  ///< the quarantine has become longer by it
    bool back;  ///< the device was offline
  };
  /// Such a frame of the device has come. Nothing if it fits no request that the device owes an
  /// answer to: then it proves nothing.
  std::optional<Late> note_unexpected(modbus::Bytes response, Instant now, const Timing& timing);

  /// How many answers to requests of this function may still be outstanding.
  [[nodiscard]] unsigned owed(std::uint8_t function, Instant now, const Timing& timing) const;
  /// How many of them look the same as the answer to this write, and do not say that it was done:
  /// they are to other ones (the answer to 15 and 16 names no value), or from before another write.
  [[nodiscard]] unsigned owed_alike(const modbus::Request& write, Instant now,
                                    const Timing& timing) const;
  /// A request of this function, unless it is a stop or the same read once more, is not sent to the
  /// device before.
  [[nodiscard]] Instant held_until(std::uint8_t function, const Timing& timing) const;
  /// Any request may be sent then.
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
  friend struct mbgate::StateReader;
  /// Answers that are owed to transmissions of one request.
  struct Debt {
    modbus::Request asked;
    unsigned count;
    Instant due;       ///< of the oldest
    Instant last_due;  ///< of the newest
    /// One of them came so late if another one comes too.
    Duration suspected{0};
    bool given_up = false;  ///< holds nothing back, but an answer to it still proves lateness
    bool outdated = false;  ///< another write has gone to the device since
    bool doubtful = false;  ///< given up, and something that fits it was taken for another answer
    /// Of the oldest whose answer is not `longest` late already.
    [[nodiscard]] Instant due_at(Instant now, Duration longest) const {
      return now > due + longest ? last_due : due;
    }
  };

  Debt& owe(const modbus::Request& asked, Instant due);
  bool answer_seen();
  void note_took(Duration took, Instant now);
  [[nodiscard]] Instant end_of(const Debt& debt, const Timing& timing) const;
  [[nodiscard]] Duration learned(Instant now) const;

  std::vector<Debt> debts_;               // oldest first
  std::optional<Instant> forgotten_due_;  // of a debt for which there was no room
  std::bitset<256> forgotten_;            // functions of such debts
  /// Since its last unanswered transmission the device has answered, last at this instant.
  std::optional<Instant> answered_at_;
  Duration longest_answer_{0};  // of this while, and of the one before
  Duration longest_before_{0};
  Instant while_began_;
  Duration learned_{0};
  Instant learned_at_ = Instant::min();

  unsigned unanswered_in_row_ = 0;  // of what was sent after the last that was answered
  Instant answered_sent_ = Instant::min();
  bool offline_ = false;
  Instant probe_at_ = Instant::min();
  Instant wanted_at_ = Instant::min();
};

}  // namespace mbgate::bus
