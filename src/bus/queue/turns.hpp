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

/// What may be sent: whatever waits, or between two stops only what may_pass_stops().
enum class Passing : bool { nothing, stops };

/// The next turn among queued jobs and jobs that wait for their next try.
[[nodiscard]] std::optional<Choice> next_turn(Parts& parts, Passing passing, Instant now);
/// Reads may, for one may show that what came was no echo, and what is for devices that no waiting
/// stop is for, unless that stop only repeats an acknowledged one.
[[nodiscard]] bool may_pass_stops(Parts& parts, const Job& job, Instant now);
/// When the bus is to be woken for the job.
[[nodiscard]] Wake wake_for(const Parts& parts, const Job& job, Instant at);

/// May another job begin? Nothing comes between the transactions of a job, unless its device must
/// be left alone meanwhile. A job with a single transaction that is to be repeated blocks no other
/// job.
[[nodiscard]] bool has_place(const Parts& parts, Instant now);

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
