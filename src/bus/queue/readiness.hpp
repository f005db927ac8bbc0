// SPDX-License-Identifier: Apache-2.0
// When a job may be transmitted as far as its device and the line are concerned, whoever else
// waits. These functions change nothing.
#pragma once

#include "bus/parts.hpp"

namespace mbgate::bus {

/// Until then the device of the job boots, may send a late answer that could be mistaken for the
/// answer to the job's request, or does not answer, and lost time is paid back to others. Nothing
/// holds a stop but that its device was given up.
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
[[nodiscard]] Transmission* in_the_way_of(const Parts& parts, const Job& stop);
/// How long what was sent has for its answer before a stop cuts it off, from when it has left. A
/// stop into an answer that is on its way is a stop lost, so the device has the time that it needs.
[[nodiscard]] Duration time_before_stop(const Parts& parts, const Transaction& sent);
/// Were an earlier stop to its device and all its repetitions unanswered, and nothing heard since?
[[nodiscard]] bool is_given_up(const Parts& parts, const Transmission& stop);
/// A stop that was given up waits until then, while lost time is paid back to others.
[[nodiscard]] Instant held_until(const Parts& parts, const Transmission& stop);
/// Is a running transaction cut short for the stop? Not if its device was given up, nor if the stop
/// only repeats an acknowledged one.
[[nodiscard]] bool may_cut(const Parts& parts, const Transmission& stop, Instant now);
/// When the stop is transmitted although the line was never silent (`stop_deadline`). Only the time
/// in which an open line is not silent counts.
[[nodiscard]] Instant stop_overdue_at(const Parts& parts, const Transmission& stop);

}  // namespace mbgate::bus
