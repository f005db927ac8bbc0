// SPDX-License-Identifier: Apache-2.0
// Which transmissions a device has not answered yet, and how long it is left alone for that.
//
// A transmission is *unanswered* until an answer that fits it has come. It is *open* until then, or
// until its tail is over: the quarantine after its response timeout. After its tail an answer is
// *owed* still. A device works in order: an answer closes the oldest unanswered transmission that
// it fits. If others are left then, the device may owe more than was counted, and is held until it
// had twice the time that all of them need at its present pace; what has not come by then is lost.
//
// While a device has an open transmission, or is held, nothing is sent to it but stops and the
// retry of the same read. A device that has answered since, and fast, may get a request of another
// function: the answer names its function, and there is no queue in such a device. So may one whose
// answer may have come, where nobody knows whether the line has an echo: only reads show that.
//
// A device that answers twice (two drives at one address, a repeater) is left alone after each
// answer until the second one must have come.
#pragma once

#include <algorithm>
#include <array>
#include <boost/container/static_vector.hpp>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "bus/instant.hpp"
#include "bus/line_end.hpp"
#include "drive/device.hpp"

namespace mbgate::bus {

// How long a device takes to answer, and how late its answers can be: learned from those that come,
// and forgotten again.

class AnswerPace {
 public:
  /// An answer came; `took`: from the end of the transmission. If it may also be the answer to an
  /// earlier transmission, `or_took` is the time from the end of that one, and counts unless the
  /// device is known to answer as fast as `took`. `is_ordinary`: not of slow registers. True: it
  /// came clearly sooner than any other answer of the last minute.
  bool note_answer(Duration took, Duration or_took, Instant now, bool is_ordinary = true) {
    if (now - while_began_ >= kRecently) {
      before_ = now - while_began_ < 2 * kRecently ? lately_ : Period{};
      lately_ = {};
      while_began_ = now;
    }
    const Duration shortest = std::min(lately_.shortest, before_.shortest);
    const bool is_first = shortest == Duration::max();
    const bool is_sudden = !is_first && took < shortest - shortest / kSuddenPart;
    const Duration counted = is_first || is_sudden ? or_took : took;
    lately_.longest = std::max(lately_.longest, counted);
    lately_.ordinary = std::max(lately_.ordinary, is_ordinary ? counted : Duration{0});
    lately_.shortest = std::min(lately_.shortest, took);
    return is_sudden;
  }
  /// A late answer came, which a quarantine as long as this would have covered.
  void note_late(Duration covering, Instant now) {
    const Duration known = learned(now);
    if (covering > known - known / kForgottenPart) {  // what is left next would not cover it
      learned_ = std::max(covering, known);
      learned_at_ = now;
    }
  }

  /// The longest that an answer took in the last minute, and in the one before.
  [[nodiscard]] Duration longest_answer() const {
    return std::max(lately_.longest, before_.longest);
  }
  /// The same without answers of slow registers.
  [[nodiscard]] Duration longest_ordinary() const {
    return std::max(lately_.ordinary, before_.ordinary);
  }
  /// How long a quarantine must be to cover what was seen of late answers. It shrinks by an eighth
  /// in each minute in which none came that the rest would not cover.
  [[nodiscard]] Duration learned(Instant now) const {
    if (learned_ == Duration{0} || now <= learned_at_) {
      return learned_;
    }
    const auto passed = (now - learned_at_) / kForgettingTime;
    Duration left = learned_;
    for (int at = 0; at < std::min<std::int64_t>(passed, kLongestMemory); ++at) {
      left -= left / kForgottenPart;
    }
    return left;
  }

 private:
  static constexpr auto kRecently = std::chrono::minutes(1);
  static constexpr auto kForgettingTime = std::chrono::minutes(1);
  static constexpr int kSuddenPart = 8;       // an eighth sooner
  static constexpr int kForgottenPart = 8;    // an eighth in each of these
  static constexpr int kLongestMemory = 100;  // of these; nothing is left by then

  struct Period {
    Duration longest{0};
    Duration ordinary{0};  ///< the longest without those of slow registers
    Duration shortest = Duration::max();
  };
  Period lately_;  // since `while_began_`
  Period before_;
  Instant while_began_;
  Duration learned_{0};
  Instant learned_at_ = Instant::min();
};

/// The most transmissions of a device that are remembered as unanswered.
inline constexpr std::size_t kMostUnanswered = 64;

/// The last answered requests of a device that are remembered, because they may be answered again.
inline constexpr std::size_t kMostAnswered = 4;

/// Added to every time for which a device is held back: an adapter may keep received bytes for this
/// long.
inline constexpr Duration kAdapterKeeps = std::chrono::milliseconds(20);

class Hold {
 public:
  using Timing = drive::DeviceTiming;

  /// A transmission: what was asked, when it began, and when its response timeout ends.
  struct Sent {
    const modbus::Request& asked;
    Instant sent;
    Instant due;
    bool is_retry = false;
    bool may_be_answered = false;  ///< what came may be its answer, or its echo
    bool is_probe = false;         ///< its response timeout is short
    bool is_slow = false;          ///< it reads or writes slow registers
    std::uint8_t unit = 0;         ///< on the wire
  };
  /// No answer came to it. `is_unreadable`: a frame came in its place that is no answer, or is
  /// damaged; its answer may still come until the response timeout is over.
  void note_unanswered(const Sent& sent, bool is_unreadable = false);
  /// The line has no echo: whatever may have been an echo was the answer.
  void note_no_echo() { std::erase_if(unanswered_, std::mem_fn(&Unanswered::may_be_answered)); }
  /// A good frame of it came, though it answers nothing.
  void note_heard(Instant now) { heard_at_ = now; }
  /// It was answered by `response` (a PDU), `took` after the end of the transmission. If an earlier
  /// try of the same request is unanswered too, it is that one's answer.
  void note_answered(const Sent& sent, modbus::Bytes response, Duration took, Instant now,
                     const Timing& timing);
  /// A request is sent to the device, and is open from now on; nullptr: nothing ever answers it.
  /// `forgets`: an offline device may have lost the same request that it was sent before, with no
  /// write to it since. Returns whether an answer within a probe's time will show that the device
  /// owes nothing else.
  bool note_asked(const modbus::Request* asked, Instant now, const Timing& timing, bool forgets);
  /// A write is sent to the device. From now on the answer to another one, sent before it, no
  /// longer proves that that one, sent once more, was carried out. After a stop this is so only for
  /// writes whose answer looks like its own.
  void note_written(const modbus::Request& write, bool is_stop);
  /// What an unexpected frame shows.
  struct Late {
    Duration lateness;
    bool grew;       ///< the frame has lengthened the quarantine
    Duration shown;  ///< lateness of what was probably answered, the first try of a request
  };
  /// An unexpected frame of the device has come: the answer to the oldest unanswered transmission
  /// that it fits. Nothing if there is none. If the device was offline and the frame fits what was
  /// sent to it just then, it may be the answer to that. The next read shows it, once the device is
  /// silent.
  std::optional<Late> note_late(modbus::Bytes response, Instant came, const Timing& timing,
                                bool was_offline);
  /// Such a frame, which is no late answer, is a second answer to a request that was answered less
  /// than a response timeout ago. False: it is not.
  bool note_second(modbus::Bytes response, Instant came, const Timing& timing);
  /// What an unexpected frame may answer: the oldest unanswered transmission of which `fits` holds;
  /// or, while nothing is on the wire, the last of those that were answered. nullptr: nothing.
  template <typename Fits>
  [[nodiscard]] const modbus::Request* oldest_that(Fits fits) const {
    const auto owed = std::ranges::find_if(unanswered_, fits, &Unanswered::asked);
    if (owed != unanswered_.end() || pending_) {
      return owed == unanswered_.end() ? nullptr : &owed->asked;
    }
    const auto last = std::find_if(answered_.rbegin(), answered_.rend(),
                                   [&](const Answered& it) { return fits(it.asked); });
    return last == answered_.rend() ? nullptr : &last->asked;
  }
  /// How many second answers have come since the last two hundred answers without one.
  [[nodiscard]] unsigned seconds() const { return seconds_; }

  /// The transmissions that an answer to `next`, which is sent now to `unit`, may belong to, oldest
  /// first: the unanswered ones, and the one that may get a second answer. Those of the same
  /// request that were sent at `first_sent` or later are its own earlier tries.
  [[nodiscard]] OwedAnswers owed(const modbus::Request& next, std::uint8_t unit, Instant first_sent,
                                 Instant now, const Timing& timing) const;
  /// The earliest instant at which this request may be sent to the device. A stop need not wait,
  /// nor does the same read once more (`repeats`), unless it shall show what the device owes.
  [[nodiscard]] Instant until(const modbus::Request& next, const Timing& timing,
                              bool repeats) const;
  /// The instant from which on any request may be sent.
  [[nodiscard]] Instant until(const Timing& timing) const;
  /// The end of the tail of a transmission that was due then.
  [[nodiscard]] Instant end_of_tail(Instant due, const Timing& timing) const {
    return due + tail(due, timing) + kAdapterKeeps;
  }
  /// The length of a tail that begins at `now`: the quarantine in force.
  [[nodiscard]] Duration tail(Instant now, const Timing& timing) const;
  /// How fast the device answers, late answers included.
  [[nodiscard]] const AnswerPace& pace() const { return pace_; }

 private:
  /// In force when a transmission began. A reload may lengthen them for it, but not shorten them.
  struct Limits {
    Duration quarantine{0};
    Duration quarantine_max{0};
  };
  struct Unanswered {
    modbus::Request asked;
    Instant sent;
    Instant due;
    bool is_unreadable;
    bool is_retry;
    bool may_be_answered;
    bool is_slow;
    std::uint8_t unit;
    Limits limits;
    bool is_outdated = false;  ///< a write, and another write has gone to the device since
    bool is_over = false;      ///< its tail
    /// An answer came to it, and was taken for that of an earlier one.
    bool was_replaced = false;
    /// How late the answer to an earlier one was, if this one is answered too.
    Duration suspected{0};
  };

  void close(std::vector<Unanswered>::iterator answered, Instant now, const Timing& timing);
  void settle(Instant now, const Timing& timing, bool was_held = false);
  void note_tail(const Unanswered& ended, bool was_answered, Instant now, const Timing& timing);
  [[nodiscard]] Instant oldest_unanswered(Instant otherwise) const;
  void hold_for_rest(Instant oldest_sent, Instant now, const Timing& timing);
  [[nodiscard]] Instant end_of_tail(const Unanswered& it, const Timing& timing) const {
    return it.is_unreadable
               ? it.due
               : it.due + std::max(it.limits.quarantine, tail(it.due, timing)) + kAdapterKeeps;
  }
  template <typename Predicate>
  [[nodiscard]] Instant end_of_tails(const Timing& timing, Predicate holds,
                                     bool decides = false) const;
  [[nodiscard]] Instant end_of_seconds(const Timing& timing) const;

  std::vector<Unanswered> unanswered_;      // oldest first, without the one on the wire
  std::optional<modbus::Request> pending_;  // that one
  Limits limits_;                           // of that one
  bool is_doubtful_ = false;                // what is owed, since a probe brought something
  bool is_decisive_ = false;                // the answer to the one on the wire ends the doubt
  Duration suspected_{0};                   // as in Unanswered, of that one
  std::optional<Instant> held_until_;       // the device may owe more than was counted
  Instant held_since_ = Instant::min();     // what was sent before that is waited for
  AnswerPace pace_;
  Instant heard_at_ = Instant::min();

  std::uint8_t tails_ = 0;                // a bit for each of the last: did it end unanswered?
  std::array<Instant, 2> silent_{};       // when the last two of these were sent
  Instant rests_until_ = Instant::min();  // it is left alone for once, to hear how late it is
  Instant rested_at_ = Instant::min();

  struct Answered {
    modbus::Request asked;
    std::uint8_t unit;
    Instant at;
  };
  boost::container::static_vector<Answered, kMostAnswered>
      answered_;             // the last ones, oldest first
  bool was_sudden_ = false;  // that answer came faster than any before it
  unsigned seconds_ = 0;     // second answers
  unsigned clean_ = 0;       // answers without one since
  Duration longest_second_{0};
};

}  // namespace mbgate::bus
