// SPDX-License-Identifier: Apache-2.0
// Whose turn it is on a bus, and when. These functions change nothing.
#pragma once

#include <optional>

#include "bus/parts.hpp"

namespace mbgate::bus {

/// The job that is sent next, when, and the job that it passes over.
struct Choice {
  Job* job;
  Instant at;
  Job* passed_over = nullptr;
};

/// Which jobs may be sent while a stop waits. By default all: no stop waits.
struct Bounds {
  const Job* before = nullptr;  ///< only those for its device that were accepted before it
  /// Only reads, and those for devices that no waiting stop is for, unless it only repeats an
  /// acknowledged one. A read may show that what came was no echo.
  bool beside_stops = false;
};

/// The next turn among queued jobs and jobs that wait for their next try.
[[nodiscard]] std::optional<Choice> next_turn(Parts& parts, const Bounds& bounds, Instant now);
/// The next turn among queued jobs.
[[nodiscard]] std::optional<Choice> next_waiting(Parts& parts, const Bounds& bounds, Instant now);
/// When the bus is to be woken for the job.
[[nodiscard]] Wake wake_for(const Parts& parts, const Job& job, Instant at);

/// May another job begin? Nothing comes between the transactions of a job, unless its device must
/// be left alone meanwhile or a stop waits. A job with a single transaction that is to be repeated
/// blocks no other job.
[[nodiscard]] bool has_place(const Parts& parts, Instant now);
[[nodiscard]] bool is_within(Parts& parts, const Bounds& bounds, const Job& job, Instant now);

/// Until then the device of the job boots, may send a late answer that could be mistaken for the
/// answer to the job's request, or does not answer, and lost time is paid back to others.
[[nodiscard]] Instant held_until(const Parts& parts, const Job& job);
[[nodiscard]] bool is_held_back(const Parts& parts, const Job& job, Instant now);
/// The first instant at which the job may be transmitted.
[[nodiscard]] Instant ready_at(const Parts& parts, const Job& job);
/// The index of the transaction that is transmitted when the turn of the job has come. Only then is
/// it known whether a check (must_hold) of the gateway's own is needed. A check is never the last
/// transaction of a job. A stop has no checks.
[[nodiscard]] std::size_t next_transaction(const Parts& parts, const Job& job);

}  // namespace mbgate::bus
