// SPDX-License-Identifier: Apache-2.0
// The order among stops, and what is sent or finished before a stop: the writes that it lets go
// first (`stop_cancels = false`), what is on the wire, and, if its drive does not answer, one turn
// of another device between two tries. These functions change nothing.
#pragma once

#include <optional>

#include "bus/queue/turns.hpp"

namespace mbgate::bus {

/// Does the stop cancel the write, which was accepted before it? A transaction that is already on
/// the wire is finished.
[[nodiscard]] bool is_stopped_by(const Parts& parts, const Job& stop, const Job& write);
/// Is the write one of those that the stop lets go first, if it has `stop_cancels = false`? A
/// broadcast is a write to every device.
[[nodiscard]] bool goes_before(const Job& write, const Job& stop);
/// Does the stop let waiting writes to its device go first (`stop_cancels = false`)?
[[nodiscard]] bool lets_writes_go(const Parts& parts, const Job& stop);
/// Does the stop let writes go first, and are there any?
[[nodiscard]] bool must_let_writes_go(const Parts& parts, const Job& stop);
/// Can none of the writes that it lets go first begin within the time that is left for them
/// (`stop_wait`, or until the stop is overdue)?
[[nodiscard]] bool is_held_too_long(Parts& parts, const Transmission& stop, Instant now);
/// How long the stop waits for something that may begin at `ready`, from when it could be sent
/// itself.
[[nodiscard]] Duration held_by(const Parts& parts, const Transmission& stop, Instant ready);

/// The transmission in flight that keeps the stop, or the writes that it lets go first, from being
/// sent; nullptr if there is none. On a Modbus TCP connection others may be in flight, but never to
/// a device with a write outstanding, and no write to a device with a read outstanding. If all
/// places (`outstanding`) are taken, it is the oldest transmission.
[[nodiscard]] Transmission* in_the_way_of(const Parts& parts, const Job& stop);
/// How long what was sent has for its answer before a stop cuts it off, from when it has left. A
/// stop into an answer that is on its way is a stop lost, so the device has the time that it needs.
[[nodiscard]] Duration time_before_stop(const Parts& parts, const Transaction& sent);
/// Is the device of the stop offline, with an earlier stop and all its repetitions unanswered?
[[nodiscard]] bool is_given_up(const Parts& parts, const Transmission& stop);
/// Is no running transaction cut short for the stop? Its device was given up, or the stop only
/// repeats an acknowledged one.
[[nodiscard]] bool waits_patiently(const Parts& parts, const Transmission& stop, Instant now);
/// The stop that has the line next: preferably one that has no writes to let go first and cuts a
/// running transaction short, then one that has no writes to let go first, then any; nullptr if
/// none waits.
[[nodiscard]] Transmission* next_stop(Parts& parts, Instant now);
/// When the stop is transmitted although the line was never silent (`stop_deadline`). Only the time
/// in which an open line is not silent counts.
[[nodiscard]] Instant stop_overdue_at(const Parts& parts, const Transmission& stop);

/// The stop that can be transmitted next.
struct StopChoice {
  Transmission* stop;
  std::optional<Choice> before;  ///< what is sent before it, because its drive does not answer
};
[[nodiscard]] std::optional<StopChoice> choose_stop(Parts& parts, Instant now);

}  // namespace mbgate::bus
