// SPDX-License-Identifier: Apache-2.0
// The quality of the answers on a line, device by device: good, with bad CRCs, never a valid frame,
// or too late. Pure counting. A verdict holds until what is seen contradicts it, or nothing is left
// of what it is based on. It is reported when it changes, with the figures that it is based on. No
// verdict rests on what a single event could explain.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>

#include "bus/instant.hpp"

namespace mbgate::bus {

enum class Quality : std::uint8_t {
  unknown,  ///< too little was seen
  good,
  bad_crc,   ///< `count` of its last `of` answers had a bad CRC or LRC
  no_frame,  ///< bytes came after each of its last `of` requests, and it never sent a valid frame
  late       ///< `count` of its last `of` requests were answered after the response timeout
};

struct QualityVerdict {
  Quality quality = Quality::unknown;
  unsigned count = 0;
  unsigned of = 0;
  Duration lateness{0};  ///< late: the largest lateness
  Duration needed{0};    ///< late: the response timeout that would be long enough

  [[nodiscard]] unsigned percent() const {
    constexpr unsigned kPercent = 100;
    return of == 0 ? 0 : count * kPercent / of;
  }
};

/// A verdict has changed: that of the device at `address` or, without an address, that of the line
/// with all its devices.
struct QualityNotice {
  std::optional<std::uint8_t> address;
  QualityVerdict verdict;
};

/// The share of answers with a bad CRC. The older an answer, the less it counts.
class CrcShare {
 public:
  void note(bool bad);
  /// Bad as soon as five answers, and one in twenty, had a bad CRC; good again when fewer than one
  /// in fifty had.
  [[nodiscard]] bool is_bad() const { return bad_now_; }
  /// Is there anything to judge?
  [[nodiscard]] bool is_known() const { return all_ > 0; }
  [[nodiscard]] QualityVerdict verdict() const {
    return {bad_now_ ? Quality::bad_crc : Quality::good, bad_, all_};
  }

 private:
  unsigned all_ = 0;
  unsigned bad_ = 0;
  bool bad_now_ = false;
};

/// The answers of one device.
class AnswerQuality {
 public:
  /// A transmission that the device should answer has ended with a valid answer.
  void note_answered();
  /// It has ended with an answer that had a bad CRC or LRC.
  void note_damaged();
  /// It has ended with a good frame of the device that does not fit what was asked.
  void note_misfit() { note_ended(true); }
  /// It has ended, and nothing was received.
  void note_silent();
  /// It has ended, and bytes were received but no valid frame. `after`: from the end of the request
  /// to the first of these bytes. `unasked`: how often bytes came on this line while no request was
  /// pending.
  void note_unreadable(Duration after, unsigned unasked);
  /// A late answer came to a transmission that had ended. Of several only the first counts until
  /// the next transmission ends: a device that was stopped and goes on sends all its answers at
  /// once.
  void note_late(Duration lateness, Duration response_timeout);
  /// A valid frame of the device came; nothing else is known of the frame.
  void note_heard() { has_answered_ = has_framed_ = true; }
  /// The line was opened again.
  void forget();

  [[nodiscard]] const QualityVerdict& verdict() const { return verdict_; }
  /// Has it ever sent a valid answer?
  [[nodiscard]] bool has_answered() const { return has_answered_; }

 private:
  void note_ended(bool in_time);
  void judge();

  CrcShare crcs_;
  std::uint32_t requests_ = 0;  // a bit for each of the last requests: was its answer late?
  unsigned most_requests_ = 0;  // how many requests these are
  bool late_since_ended_ = false;
  Duration lateness_{0};  // the largest of these
  Duration needed_{0};
  unsigned unreadable_in_row_ = 0;
  Duration first_after_{0};  // the earliest and the latest of these
  Duration last_after_{0};
  unsigned unasked_before_ = 0;  // when the row began
  bool has_answered_ = false;
  bool has_framed_ = false;  // since the line was opened
  QualityVerdict verdict_;
};

class LineQuality {
 public:
  [[nodiscard]] AnswerQuality& operator[](std::uint8_t address) { return devices_.at(address); }
  [[nodiscard]] const AnswerQuality& operator[](std::uint8_t address) const {
    return devices_.at(address);
  }
  /// A complete answer of any device came, with a good or a bad CRC.
  void note_answer(bool bad) { crcs_.note(bad); }
  /// Bytes came while no request was pending.
  void note_unasked() { ++unasked_; }
  [[nodiscard]] unsigned unasked() const { return unasked_; }
  void forget();
  /// Another device is at this address now.
  void forget(std::uint8_t address);
  /// Good or bad CRCs of all devices together. Bad only if at least two devices are bad: one bad
  /// device alone is not a fault of the line.
  [[nodiscard]] QualityVerdict verdict() const;
  /// A verdict that has changed since the last call: that of this device, or because of it that of
  /// the line. Call it until it returns nothing. A change from unknown to good is not reported, nor
  /// is one to unknown, or from there back to what was reported before.
  std::optional<QualityNotice> take_change(std::uint8_t address);

 private:
  static constexpr std::size_t kAddresses = std::numeric_limits<std::uint8_t>::max() + 1;

  std::array<AnswerQuality, kAddresses> devices_{};
  std::array<Quality, kAddresses> reported_{};
  CrcShare crcs_;
  Quality line_reported_ = Quality::unknown;
  unsigned unasked_ = 0;
};

}  // namespace mbgate::bus
