// SPDX-License-Identifier: Apache-2.0
// What the answers on a line are like, device by device: good, with bad CRCs, never a frame, or too
// late. Pure counting: a verdict holds until what was seen says otherwise, it is told when it
// changes, and it carries what it rests on. Nothing is said that a single event could explain.
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
  late       ///< after `count` of its last `of` requests the answer came after its time
};

struct QualityVerdict {
  Quality quality = Quality::unknown;
  unsigned count = 0;
  unsigned of = 0;
  Duration lateness{0};  ///< late: at most so much
  Duration needed{0};    ///< late: the response timeout that would do

  [[nodiscard]] unsigned percent() const {
    constexpr unsigned kPercent = 100;
    return of == 0 ? 0 : count * kPercent / of;
  }
};

/// A verdict has changed: of the device at an address, or of the line with all its devices.
struct QualityNotice {
  std::optional<std::uint8_t> address;
  QualityVerdict verdict;
};

/// Answers with bad CRCs among the last ones; what is long past counts less and less.
class CrcShare {
 public:
  void note(bool bad);
  /// Bad as soon as five of them and a twentieth are, until it is less than a fiftieth.
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
  /// A transmission that it should answer has ended: with a valid answer,
  void note_answered();
  /// with one that had a bad CRC,
  void note_damaged();
  /// with nothing,
  void note_silent();
  /// or with bytes, which began so long after the request, but no frame. `unasked` counts how often
  /// bytes came on this line that nobody had asked for.
  void note_unreadable(Duration after, unsigned unasked);
  /// The answer to a transmission that had ended came after all. Of several only the first counts
  /// until the next transmission ends: what was stopped and goes on sends them all at once.
  void note_late(Duration lateness, Duration response_timeout);
  /// A valid frame of it came, of which nothing else is known.
  void note_heard() { has_answered_ = has_framed_ = true; }
  /// The line was opened anew.
  void forget();

  [[nodiscard]] const QualityVerdict& verdict() const { return verdict_; }
  /// Has it ever sent a valid answer?
  [[nodiscard]] bool has_answered() const { return has_answered_; }

 private:
  void note_ended(bool in_time);
  [[nodiscard]] unsigned least_unreadable() const;
  void judge();

  CrcShare crcs_;
  std::uint32_t requests_ = 0;  // bit by bit, the last ones: was an answer late?
  unsigned most_requests_ = 0;  // how many these are
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
  /// An answer of any device came, whole, with a good or a bad CRC.
  void note_answer(bool bad) { crcs_.note(bad); }
  /// Bytes came while nothing was asked.
  void note_unasked() { ++unasked_; }
  [[nodiscard]] unsigned unasked() const { return unasked_; }
  void forget();
  /// Good or bad CRCs of all devices together; bad only if those of two devices are, since that is
  /// not one device's matter any more.
  [[nodiscard]] QualityVerdict verdict() const;
  /// What has changed of this device, or by it of the line, since it was asked for it last; to
  /// be asked until nothing is left. From unknown to good is no change to speak of.
  std::optional<QualityNotice> take_change(std::uint8_t address);

 private:
  static constexpr std::size_t kAddresses = std::numeric_limits<std::uint8_t>::max() + 1;

  std::array<AnswerQuality, kAddresses> devices_{};
  std::array<Quality, kAddresses> told_{};
  CrcShare crcs_;
  Quality line_told_ = Quality::unknown;
  unsigned bad_devices_ = 0;
  unsigned unasked_ = 0;
};

}  // namespace mbgate::bus
