// SPDX-License-Identifier: Apache-2.0
// What a bus does next. Stops go first, then what was begun (jobs of several transactions), then
// writes, then reads. Within a class clients take turns; requests to devices that do not answer
// wait while lost time is paid back (`held_until`). Nothing here changes anything.
//
// To change
// - what is sent next, what waits for a booting drive, what is sent between two tries: scheduler,
//   bus_queue.
// - what is refused or answered before it waits, eviction: bus/admission.
// - the order among stops, also to drives that do not answer: scheduler_stops; their tries:
//   bus/transmission/outcomes.
#pragma once

#include <optional>

#include "bus/parts.hpp"

namespace mbgate::bus {

// When a job may be transmitted as far as its device and the line are concerned, whoever else
// waits. These functions change nothing.

/// Until then the device of the job boots, may send a late answer that could be mistaken for the
/// answer to the job's request, or does not answer, and lost time is paid back to others. A stop
/// waits only for the last of these, and only if its device was given up.
[[nodiscard]] Instant held_until(const Parts& parts, const Job& job);
[[nodiscard]] bool is_held_back(const Parts& parts, const Job& job, Instant now);
/// The first instant at which the job may be transmitted. Does it end a silence, or what holds the
/// job?
[[nodiscard]] Wake ready_at(const Parts& parts, const Job& job);
/// The index of the transaction that is transmitted when the turn of the job has come. Only then is
/// it known whether a check (must_hold) of the gateway's own is needed. A check is never the last
/// transaction of a job. A stop has no checks.
[[nodiscard]] std::size_t next_transaction(const Parts& parts, const Job& job);

/// The transmission in flight that keeps the stop from being sent; nullptr if there is none. On a
/// serial line any does. With the identifiers of Modbus TCP nothing collides: only another stop to
/// the same device does.
[[nodiscard]] Job* in_the_way_of(const Parts& parts, const Job& stop);
/// How long what was sent has for its answer before a stop cuts it off, from when it has left. A
/// stop into an answer that is on its way is a stop lost, so the device has the time that it needs.
[[nodiscard]] Duration time_before_stop(const Parts& parts, const Transaction& sent);
/// Were an earlier stop to its device and all its repetitions unanswered, and nothing heard since?
[[nodiscard]] bool is_given_up(const Parts& parts, const Job& stop);
/// Is a running transaction cut short for the stop? Not if its device was given up, nor if the stop
/// only repeats an acknowledged one.
[[nodiscard]] bool may_cut(const Parts& parts, const Job& stop, Instant now);
/// When the stop is transmitted although the line was never silent (`stop_deadline`). Only the time
/// in which an open line is not silent counts.
[[nodiscard]] Instant stop_overdue_at(const Parts& parts, const Job& stop);

/// The next step of a bus.
struct Next {
  enum class Step : std::uint8_t {
    wait,      ///< until `at`, if it is known, or until something comes in
    transmit,  ///< `job`: it waits in the queue or the stop lane, or is between two transmissions
    cancel,    ///< `job`, a stop: nobody wants it any more
    give_up    ///< the same: it was sent on a line that is never silent, and not acknowledged
  };
  Step step = Step::wait;
  std::optional<Wake> at{};
  Job* job = nullptr;
};

class Scheduler {
 public:
  /// The parts must outlive it. Stops whose rest is over, and the next parts of stops, must be in
  /// the lane.
  explicit Scheduler(Parts& parts) : parts_(parts) {}
  [[nodiscard]] Next next(Instant now) const;

 private:
  /// A job, and when it goes.
  struct Choice {
    Job* job;
    Wake when;
    [[nodiscard]] Instant at() const { return when.at; }
  };
  /// What may be sent: whatever waits, or between two stops only what may_pass_stops().
  enum class Passing : bool { nothing, stops };

  // scheduler.cpp: among the jobs
  [[nodiscard]] Next next_part(Instant now) const;
  [[nodiscard]] Choice ready(Job& job, Instant now) const {
    const Wake wake = ready_at(parts_, job);
    return {&job, {std::max(now, wake.at), wake.ends_silence}};
  }
  [[nodiscard]] bool has_place(Instant now) const;
  [[nodiscard]] std::optional<Choice> next_turn(Passing passing, Instant now) const;
  [[nodiscard]] std::optional<Choice> next_waiting(Passing passing, Instant now) const;
  [[nodiscard]] Job* next_repeated(Passing passing, Instant now) const;
  [[nodiscard]] bool goes_before_repeated(const Choice& choice, const Choice& repeated) const;
  [[nodiscard]] bool reads_go_first() const {
    return parts_.last_sent.writes_in_row() >= parts_.settings.burst;
  }
  [[nodiscard]] bool may_join(const Job& job) const;

  // scheduler_stops.cpp: among the stops, and between two of them
  [[nodiscard]] Job* choose_stop(Instant now) const;
  [[nodiscard]] Next next_stop(Job& stop, Instant now) const;
  [[nodiscard]] bool gives_way(const Job& stop, Instant now) const;
  [[nodiscard]] std::optional<Choice> turn_before(const Job& stop, Instant now) const;
  [[nodiscard]] bool may_pass_stops(const Job& job) const;

  Parts& parts_;
};

}  // namespace mbgate::bus
