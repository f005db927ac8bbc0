// SPDX-License-Identifier: Apache-2.0
// Carries out what the Scheduler decides: has the bytes read that have already arrived
// (LookAtLine), and transmits the frame. It also ends jobs that are over, and has the line opened
// for jobs that wait for it.
#pragma once

#include "bus/health/line_diagnosis.hpp"
#include "bus/parts.hpp"
#include "bus/queue/scheduler.hpp"
#include "bus/transmission/job_ends.hpp"
#include "bus/transmission/outcomes.hpp"

namespace mbgate::bus {

class Dispatch {
 public:
  Dispatch(Parts& parts, JobEnds& ends, Outcomes& outcomes, LineDiagnosis& diagnosis)
      : parts_(parts), ends_(ends), outcomes_(outcomes), diagnosis_(diagnosis) {}

  /// Ends jobs that are over, and transmits what may be sent now.
  void pump(Instant now);
  /// The same, when the bytes that had already arrived have been handed in and nothing else has
  /// happened since: a transmission need not wait for LookAtLine.
  void pump_looked(Instant now);
  /// The connection rests: who waits goes on waiting, and it is opened again at once, or when
  /// somebody asks.
  void rest(Instant now);
  /// The line is lost: no handle_looked() follows.
  void forget_look() { looking_ = Looking::no; }
  /// Something may be sent now that could not at the last decision.
  void wake_at_once() { wait_for(wake_at(parts_.pumped_at)); }
  /// The first instant that it waits for.
  [[nodiscard]] std::optional<Wake> next_wake() const { return next_wake_; }

 private:
  enum class Looking : std::uint8_t { no, asked, done };

  void wait_for(std::optional<Wake> wake) { next_wake_ = earlier(next_wake_, wake); }

  // dispatch.cpp: what goes next
  void decide(Instant now);
  [[nodiscard]] bool has_looked();
  bool reopen_if_hung(Instant now);
  void wait_for_line(Instant now);
  void watch_deadlines(Instant now);
  void go_on_with_stops();
  void limit_waits(Instant now);
  bool carry_out(const Next& next, Instant now);
  void begin(Job& job, Instant now);

  // dispatch_transmit.cpp: it goes on the wire
  void transmit(Job& job, Instant now);
  void check_allowed(const Job& job, Instant now) const;
  bool note_asked(const Job& job, Instant now);
  void note_changing(const Transaction& sent);
  drive::DeviceTiming note_transmission(Job& job, Instant now);

  Parts& parts_;
  JobEnds& ends_;
  Outcomes& outcomes_;
  LineDiagnosis& diagnosis_;
  Scheduler scheduler_{parts_};
  std::optional<Wake> next_wake_;
  Looking looking_ = Looking::no;
};

}  // namespace mbgate::bus
