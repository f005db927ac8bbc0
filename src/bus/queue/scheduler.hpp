// SPDX-License-Identifier: Apache-2.0
// What a bus does next. Stops go first, then what was begun (jobs of several transactions), then
// writes, then reads. Within a class clients take turns; requests to devices that do not answer
// wait while lost time is paid back (`held_until`). Nothing here changes anything.
//
// To change
// - what is sent next, what waits for a booting drive, what is sent between two tries: scheduler,
//   bus_queue.
// - what is refused or answered before it waits, eviction: admission.
// - the order among stops, also to drives that do not answer: scheduler_stops; their tries:
//   bus/transmission/outcomes.
#pragma once

#include <optional>

#include "bus/queue/readiness.hpp"

namespace mbgate::bus {

/// The next step of a bus.
struct Next {
  enum class Step : std::uint8_t {
    wait,      ///< until `at`, if it is known, or until something comes in
    transmit,  ///< `job`: it waits in the queue, or leads a transmission; or `stop` of the lane
    cancel,    ///< `stop`: nobody wants it any more
    give_up    ///< `stop`: it was sent on a line that is never silent, and not acknowledged
  };
  Step step = Step::wait;
  std::optional<Wake> at{};
  Job* job = nullptr;
  Transmission* stop = nullptr;
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
  [[nodiscard]] Transmission* choose_stop(Instant now) const;
  [[nodiscard]] Next next_stop(Transmission& stop, Instant now) const;
  [[nodiscard]] bool gives_way(const Transmission& stop, Instant now) const;
  [[nodiscard]] std::optional<Choice> turn_before(const Transmission& stop, Instant now) const;
  [[nodiscard]] bool may_pass_stops(const Job& job, Instant now) const;

  Parts& parts_;
};

}  // namespace mbgate::bus
