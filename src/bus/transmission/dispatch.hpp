// SPDX-License-Identifier: Apache-2.0
// Decides what a bus transmits and when: finds whose turn it is, has the bytes read that have
// already arrived (LookAtLine), and transmits the frame.
#pragma once

#include <optional>

#include "bus/health/line_diagnosis.hpp"
#include "bus/parts.hpp"
#include "bus/queue/stop_order.hpp"
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
  void wake_at_once() { next_start_ = Wake{parts_.pumped_at}; }
  /// When the next transmission may begin, or a waiting job ends, as far as is known.
  [[nodiscard]] const std::optional<Wake>& next_start() const { return next_start_; }

 private:
  enum class Looking : std::uint8_t { no, asked, done };

  // dispatch.cpp: what goes next
  void decide(Instant now);
  void wait_until(Wake wake) { next_start_ = earlier(next_start_, wake); }
  [[nodiscard]] bool has_looked();
  bool reopen_if_hung(Instant now);
  void wait_for_line(Instant now);
  void watch_deadlines(Instant now);
  bool serve_stops(Instant now);
  void go_on_with_stops(Instant now);
  bool send_stops(Instant now);
  bool send_stop(Transmission& stop, Instant now);
  void continue_running(Instant now);
  Transmission& begin(const Choice& choice, Instant now);

  // dispatch_transmit.cpp: it goes on the wire
  void transmit(Transmission& transmission, Instant now);
  void skip_known_settings(Transmission& transmission) const;
  void check_allowed(const Transmission& transmission, Instant now) const;
  void note_asked(const Transaction& sent, JobClass job_class, Instant now);
  drive::DeviceTiming note_transmission(Transmission& transmission, Instant now);

  Parts& parts_;
  JobEnds& ends_;
  Outcomes& outcomes_;
  LineDiagnosis& diagnosis_;
  std::optional<Wake> next_start_;
  Looking looking_ = Looking::no;
};

}  // namespace mbgate::bus
