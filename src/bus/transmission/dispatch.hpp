// SPDX-License-Identifier: Apache-2.0
// What a bus transmits when: it asks whose turn it is, has the line looked at, and puts the frame
// on the wire.
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

  /// Ends what is over, and transmits what may go now.
  void pump(Instant now);
  /// What lay in the line has been handed in, and nothing else since: the same, and what goes need
  /// not wait for that.
  void pump_looked(Instant now);
  /// The line is not there any more: nobody looks at it.
  void forget_look() { looking_ = Looking::no; }
  /// Something may go now that could not when it was decided last.
  void wake_at_once() { next_start_ = Wake{parts_.pumped_at}; }
  /// When a transmission may begin, or what waits for one ends, as far as is known.
  [[nodiscard]] const std::optional<Wake>& next_start() const { return next_start_; }

 private:
  friend struct mbgate::StateReader;
  enum class Looking : std::uint8_t { no, asked, done };

  // dispatch.cpp: what goes next
  void wait_until(Wake wake) { next_start_ = earlier(next_start_, wake); }
  [[nodiscard]] bool has_looked();
  bool reopen_if_hung(Instant now);
  void wait_for_line();
  void watch_deadlines();
  bool serve_stops(Instant now);
  void go_on_with_stops(Instant now);
  void take_back_held_writes(Instant now);
  bool send_stops(Instant now);
  bool send_stop(Transmission& stop, Instant now);
  void continue_running(Instant now);
  Transmission& begin(const Choice& choice, Instant now);

  // dispatch_transmit.cpp: it goes on the wire
  void transmit(Transmission& transmission, Instant now);
  void skip_known_settings(Transmission& transmission) const;
  void check_allowed(const Transmission& transmission, Instant now) const;
  drive::DeviceTiming note_transmission(Transmission& transmission, Instant now);

  Parts& parts_;
  JobEnds& ends_;
  Outcomes& outcomes_;
  LineDiagnosis& diagnosis_;
  std::optional<Wake> next_start_;
  Looking looking_ = Looking::no;
};

}  // namespace mbgate::bus
