// SPDX-License-Identifier: Apache-2.0
// The order among stops, what is finished before a stop, and what is sent between two stops to
// drives that do not answer. These functions change nothing.
#pragma once

#include <optional>

#include "bus/queue/turns.hpp"

namespace mbgate::bus {

/// Does the stop cancel the write, which was accepted before it? A transaction that is already on
/// the wire is finished.
[[nodiscard]] bool is_stopped_by(const Parts& parts, const Job& stop, const Job& write);
/// The transmission in flight that keeps the stop from being sent; nullptr if there is none. On a
/// serial line any does. On a Modbus TCP connection nothing collides: only another stop to the same
/// device does.
[[nodiscard]] Transmission* in_the_way_of(const Parts& parts, const Job& stop);
/// How long what was sent has for its answer before a stop cuts it off, from when it has left. A
/// stop into an answer that is on its way is a stop lost, so the device has the time that it needs.
[[nodiscard]] Duration time_before_stop(const Parts& parts, const Transaction& sent);
/// Is the device of the stop offline, with an earlier stop and all its repetitions unanswered?
[[nodiscard]] bool is_given_up(const Parts& parts, const Transmission& stop);
/// A stop that was given up waits until then, while lost time is paid back to others.
[[nodiscard]] Instant held_until(const Parts& parts, const Transmission& stop);
/// Is no running transaction cut short for the stop? Its device was given up, or the stop only
/// repeats an acknowledged one.
[[nodiscard]] bool waits_patiently(const Parts& parts, const Transmission& stop, Instant now);
/// When the stop is transmitted although the line was never silent (`stop_deadline`). Only the time
/// in which an open line is not silent counts.
[[nodiscard]] Instant stop_overdue_at(const Parts& parts, const Transmission& stop);

/// The stop that can be transmitted next.
struct StopChoice {
  Transmission* stop;
  std::optional<Choice> before;  ///< what is sent before it
};
/// Stops to drives that answer go first. Between two others, which go to drives that do not answer
/// or only repeat acknowledged ones, something else that waits is sent.
[[nodiscard]] std::optional<StopChoice> choose_stop(Parts& parts, Instant now);

}  // namespace mbgate::bus
