// SPDX-License-Identifier: Apache-2.0
// What is noticed of a line and its devices beside the answers: their quality, frames that answer
// nothing (late answers, other clients, echoes), lines that are never silent. Each is told once
// until it is over.
#pragma once

#include "bus/bus_action.hpp"
#include "bus/health/line_quality.hpp"
#include "bus/parts.hpp"
#include "bus/serial/serial_discipline.hpp"

namespace mbgate::bus {

/// What had been asked by a transmission that has ended.
struct Asked {
  std::uint8_t address;
  bool is_read;
  bool wants_answer;
};

class LineDiagnosis {
 public:
  explicit LineDiagnosis(Parts& parts) : parts_(parts) {}

  void note_opened();
  /// Bytes were handed in; `asked`: while something was asked.
  void note_bytes(bool asked, Instant now);
  /// A good frame came that answers nothing that is asked now.
  void note_unsolicited(const UnsolicitedFrame& unsolicited);
  /// An answer to what was asked came.
  void note_understood() { never_silent_reported_ = false; }
  void note_ended(const Asked& asked, const LineEnd& end);
  /// The far end takes what is sent and says nothing. True: the first time since it said something.
  bool note_unanswered_connection();
  void notify(DeviceNotice::Kind kind, std::uint8_t address);

  [[nodiscard]] const LineQuality& quality() const { return quality_; }

 private:
  friend struct mbgate::StateReader;
  void note_foreign(const UnsolicitedFrame& unsolicited);
  void note_denied_echo(bool was_heard);
  void tell_quality(std::uint8_t address);

  Parts& parts_;
  LineQuality quality_;
  bool never_silent_reported_ = false;
  bool foreign_reported_ = false;
  bool replacement_reported_ = false;
  bool frame_heard_ = false;    // a stray one, since a transmission ended last
  bool own_heard_ = false;      // the own request, since a transmission ended last
  unsigned denied_echoes_ = 0;  // so many in a row: a read that is answered without one ends it
};

}  // namespace mbgate::bus
