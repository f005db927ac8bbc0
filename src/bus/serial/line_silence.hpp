// SPDX-License-Identifier: Apache-2.0
// The silence of a serial line: since when nothing has passed on it in either direction, and when
// that suffices for the next transmission. A transmission also waits for the turnaround delay of a
// broadcast and, unless it is a stop, for a line that was opened just now or that is to settle
// because an answer is missing.
#pragma once

#include <algorithm>
#include <cstddef>

#include "bus/instant.hpp"
#include "bus/settings.hpp"

namespace mbgate::bus {

class LineSilence {
 public:
  /// `settings` must outlive this object and always be those in force.
  explicit LineSilence(const BusSettings& settings)
      : settings_(settings), timing_(settings.line.baud, settings.line.format) {}

  /// The line was opened: it is listened to until then.
  void open(Instant now, Instant listen_until) {
    quiet_since_ = now;
    busy_since_ = now;
    note_pause(false);
    emission_ends_ = now;
    listening_until_ = listen_until;
    settling_until_ = now;
    turnaround_until_ = std::max(turnaround_until_, now);  // the drives know nothing of the adapter
  }
  /// An own frame of so many bytes begins.
  void note_frame(std::size_t bytes, Instant now) {
    const bool was_silent = is_silent(now);
    emission_ends_ = now + timing_.duration_of(bytes);
    quiet_since_ = emission_ends_;
    busy_since_ = was_silent ? emission_ends_ : busy_since_;  // it ends no noise
    note_pause(false);
  }
  /// It is a broadcast: the turnaround delay follows it.
  void note_broadcast() { turnaround_until_ = emission_ends_ + settings_.turnaround; }
  /// Bytes were read.
  void note_bytes(Instant now) {
    if (now > quiet_since_ + pause_) {
      busy_since_ = now;
    }
    quiet_since_ = std::max(quiet_since_, now);
  }
  /// Has a frame begun in what was read? Then it may pause for `frame_slack`.
  void note_pause(bool is_amid_frame) {
    pause_ =
        is_amid_frame ? std::max(frame_gap(), settings_.frame_slack_or_default()) : frame_gap();
  }
  /// A response is missing.
  void note_unanswered(Instant now) {
    settling_until_ = std::max(settling_until_, now + settings_.settle);
  }

  /// From when on the silence before a transmission suffices; `gap` is asked for on top of it.
  [[nodiscard]] Instant ready_at(Duration gap) const {
    return std::max(std::max(quiet_since_ + pause_ + gap, settling_until_),
                    std::max(listening_until_, turnaround_until_));
  }
  /// The same for a stop, which waits for nothing but silence and a turnaround delay.
  [[nodiscard]] Instant ready_for_stop_at() const {
    return std::max(quiet_since_ + pause_, turnaround_until_);
  }
  /// The same where nobody waits for silence: an own frame and a turnaround delay are over.
  [[nodiscard]] Instant possible_at() const { return std::max(emission_ends_, turnaround_until_); }
  /// Since when the line is silent: the last byte that was read, or the end of the own frame, which
  /// may be still to come.
  [[nodiscard]] Instant quiet_since() const { return quiet_since_; }
  /// Since when bytes follow each other without the silence before a transmission. If they have
  /// ended, ready_for_stop_at() tells.
  [[nodiscard]] Instant busy_since() const { return busy_since_; }
  /// When the last own frame has left.
  [[nodiscard]] Instant emission_ends() const { return emission_ends_; }
  /// Has the silence before a transmission come?
  [[nodiscard]] bool is_silent(Instant now) const { return now >= quiet_since_ + pause_; }
  [[nodiscard]] bool is_listening(Instant now) const { return now < listening_until_; }
  [[nodiscard]] bool is_in_turnaround(Instant now) const { return now < turnaround_until_; }
  /// How long the characters of the line take.
  [[nodiscard]] const modbus::RtuTiming& timing() const { return timing_; }

 private:
  [[nodiscard]] Duration frame_gap() const { return settings_.frame_gap.value_or(timing_.t3_5()); }

  const BusSettings& settings_;
  modbus::RtuTiming timing_;
  Duration pause_ = frame_gap();  // behind the last byte: longer where a frame may go on
  Instant quiet_since_;           // the last byte in either direction
  Instant busy_since_;            // the first one after the last silence
  Instant settling_until_;
  Instant listening_until_;
  Instant turnaround_until_;
  Instant emission_ends_;
};

}  // namespace mbgate::bus
