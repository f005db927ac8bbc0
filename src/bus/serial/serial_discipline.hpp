// SPDX-License-Identifier: Apache-2.0
// The line discipline of a serial line, RTU or ASCII: one transaction at a time, silence before
// each transmission, a time limit for each response. It knows nothing of queues and retries; the
// bus above decides what is sent when. States as in Serial Line V1.02, figures 7 and 14.
//
// To change
// - when a response belongs to its request: modbus/response, rtu_framer, ascii_framer.
// - bytes before a response that are no part of it, pauses within one: rtu_search; pauses within an
//   unsolicited frame: cut_frame.
// - silence, settling, turnaround: line_silence; timeouts: serial_discipline.
// - whether a frame is the answer, a late answer, or an echo: serial_discipline_answers.
// - whether a line has an echo, and its removal: echo; one that the settings deny:
//   bus/health/line_diagnosis.
#pragma once

#include <optional>
#include <utility>

#include "bus/counters.hpp"
#include "bus/job.hpp"
#include "bus/line_end.hpp"
#include "bus/serial/echo.hpp"
#include "bus/serial/framer.hpp"
#include "bus/serial/line_silence.hpp"
#include "bus/settings.hpp"

namespace mbgate::bus {

class SerialDiscipline {
 public:
  /// `settings` must outlive this object and always be those in force.
  SerialDiscipline(const BusSettings& settings, BusCounters& counters);
  SerialDiscipline(const SerialDiscipline&) = delete;  // its parts refer to each other
  SerialDiscipline& operator=(const SerialDiscipline&) = delete;

  /// The line was opened: it is listened to until then, nothing of before counts any more.
  void open(Instant now, LineKind kind, Instant listen_until);
  /// Other times on the same line.
  void update();
  /// When something may be sent.
  [[nodiscard]] const LineSilence& silence() const { return silence_; }
  /// Starts to transmit now; no other transaction may be running, and `transaction`, which gets the
  /// response, must outlive its end. An answer that fits one of `owed` first, which is no try of
  /// its own, belongs to that one and is refused, once. Returns the frame.
  FrameBytes begin(Transaction& transaction, const drive::DeviceTiming& timing, OwedAnswers owed,
                   Instant now);
  /// The running transaction has so long for its response, from when it has left, and no longer
  /// than its timeout. A response that has begun by then is waited for.
  void limit_wait(const Transaction& transaction, Duration longest);
  /// A good frame of the device came that does not fit the running transaction. It ends at `over`,
  /// unless its answer has begun by then; without that the device may answer so, and has.
  void take_misfit(const modbus::Pdu& frame, std::optional<Instant> over);
  /// When the response timeout of the last transmission ends.
  [[nodiscard]] Instant response_due() const { return response_due_; }
  /// Gives up the running transaction: nothing of it will be reported.
  void abort();

  /// The driver holds so many bytes that it has not sent yet.
  void note_unsent(std::size_t bytes) { unsent_ = bytes; }
  /// Something is about to be transmitted. What the driver holds would leave in front of it, when
  /// nobody waits for it any more: a fault, here and at the end of a response timeout. Returns
  /// whether it is one.
  bool handle_looked(Instant now);

  void handle_bytes(modbus::Bytes bytes, Instant now);
  void handle_deadline(Instant now);
  [[nodiscard]] std::optional<Instant> next_deadline() const;
  /// The end of the running transaction, once.
  std::optional<LineEnd> take_end() { return std::exchange(end_, std::nullopt); }
  /// What was noticed of the line itself since the last call.
  std::optional<LineFault> take_fault() { return faults_.take(); }
  /// A good frame that answers nothing that was asked, each once.
  std::optional<UnsolicitedFrame> take_unsolicited();
  [[nodiscard]] LineState state(Instant now) const;
  [[nodiscard]] NoticedEcho noticed_echo() const { return echo_.noticed(); }

 private:
  void judge_held(const Echo::Held& held, Instant now);
  Verdict refuse_others(Verdict verdict, Instant now);
  Verdict refuse(Instant now);
  Verdict settle_echo(Verdict verdict, Instant now);
  void judge(Verdict verdict, Instant now);
  void end(LineEnd::How how);

  const BusSettings& settings_;
  LineSilence silence_;
  bool paced_ = false;
  BusCounters& counters_;
  LineFaults faults_;
  Echo echo_;
  Framer framer_;

  Transaction* transaction_ = nullptr;
  Instant response_due_;       // the end of the response timeout
  Instant response_deadline_;  // the same, or earlier because a stop waits
  bool is_hurried_ = false;    // because a stop waits
  Duration response_wait_{0};  // the device holds its answer back for so long
  OwedAnswers owed_;           // those that may still come
  bool misfit_ = false;        // a frame came that answers nothing
  bool may_be_echo_ = false;   // one came that proves nothing
  Untold<UnsolicitedFrame, kMostUnsolicited>
      refused_;            // of these, those that came, and were not told yet
  bool draining_ = false;  // what came last was no response: it must end first
  std::size_t heard_ = 0;  // bytes since the last own frame had left
  Instant heard_at_;       // the first of them
  bool unpaced_reported_ = false;
  std::size_t unsent_ = 0;
  bool is_answerless_ = false;  // nothing answers what was sent last
  std::optional<LineEnd> end_;
};

}  // namespace mbgate::bus
