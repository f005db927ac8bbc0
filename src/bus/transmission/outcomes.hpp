// SPDX-License-Identifier: Apache-2.0
// Handles the end of a transmission: draws conclusions about the device from the answer or its
// absence, and decides whether the transmission is repeated, the job continues with its next
// transaction, or the job is over.
//
// To change
// - retries, the meaning of the end of a transmission: outcomes; an adapter that hangs:
//   bus/link_state.
// - reads that are sent once for several clients: dispatch_transmit; which job leads when the
//   leader leaves: transmission, job_ends; the cache: read_cache.
// - when a line is opened again: bus/link_state, bus/bus; requests cut off by a close: outcomes.
#pragma once

#include "bus/health/line_diagnosis.hpp"
#include "bus/parts.hpp"
#include "bus/transmission/job_ends.hpp"

namespace mbgate::bus {

/// An exception that says "not now": 05, 06, 0A or 0B.
[[nodiscard]] bool is_passing(const modbus::Pdu& response);

class Outcomes {
 public:
  Outcomes(Parts& parts, JobEnds& ends, LineDiagnosis& diagnosis)
      : parts_(parts), ends_(ends), diagnosis_(diagnosis) {}

  void handle_end(LineEnd end, Instant now);
  /// The line was lost: stops that were in flight are sent once more, if they may be.
  void handle_cut_stops(Instant now);
  /// A connection was closed by the server: what was in flight has no answer.
  void handle_cut(Instant now);
  /// The line is lost: devices may still answer what was on the wire.
  void note_lost(Instant now);
  /// The stop has had all its tries.
  void give_up_stop(Job& stop, Instant now);

 private:
  void take_response(Job& job, const LineEnd& end, Instant now);
  void handle_response(Job& job, const LineEnd& end, Instant now);
  void note_unreached(Job& job, Instant now);
  void note_unanswered(Job& job, Instant due, Instant now);
  [[nodiscard]] bool holds_what_it_must(const Transaction& question);
  void note_stopped(const Job& job, Instant now);
  void handle_silence(Job& job, const LineEnd& end, Instant now);
  void handle_unreadable(Job& job, const LineEnd& end, Instant now);
  void handle_failure(Job& job, Instant now);
  void handle_stop_failure(Job& stop, Instant now);
  bool repeat_refused(Job& stop, Instant now);
  void part_from_untried(Job& stop);
  void remember(const Job& job);

  Parts& parts_;
  JobEnds& ends_;
  LineDiagnosis& diagnosis_;
};

}  // namespace mbgate::bus
