// SPDX-License-Identifier: Apache-2.0
// The order among stops, and what goes before one: the writes that it lets go first, what is on the
// wire, and, where a drive answers none, a turn of another device between two tries. Nothing here
// changes anything.
#pragma once

#include <optional>

#include "bus/queue/turns.hpp"

namespace mbgate::bus {

/// Does the stop forbid the write, which was accepted before it? What is on the wire already is
/// finished.
[[nodiscard]] bool is_stopped_by(const Parts& parts, const Job& stop, const Job& write);
/// Is it one of those that a stop with `stop_cancels = false` lets go first? A broadcast is a write
/// to every device.
[[nodiscard]] bool goes_before(const Job& write, const Job& stop);
[[nodiscard]] bool lets_writes_go(const Parts& parts, const Job& stop);
/// It lets them go first, and there are some.
[[nodiscard]] bool must_let_writes_go(const Parts& parts, const Job& stop);
/// Can none of the writes that it lets go first begin in the time that is left for them?
[[nodiscard]] bool is_held_too_long(Parts& parts, const Transmission& stop, Instant now);
/// For how long the stop, which could go itself, waits for what may begin then.
[[nodiscard]] Duration held_by(const Parts& parts, const Transmission& stop, Instant ready);

/// What keeps it, or the writes that it lets go first, from being transmitted. On a connection
/// others may be on their way, but never to a device that has a write outstanding, nor a write to
/// one that has a read outstanding; where all places are taken, the one that has had its place for
/// longest.
[[nodiscard]] Transmission* in_the_way_of(const Parts& parts, const Job& stop);
/// Nothing that runs is cut for a stop to a device that is offline and was given up.
[[nodiscard]] bool waits_patiently(const Parts& parts, const Transmission& stop);
/// The stop that waits for the line: before all others one that cuts what runs, and before those
/// that let writes go first one that does not.
[[nodiscard]] Transmission* next_stop(Parts& parts);
/// When the line was not silent for so long that the stop is transmitted all the same. Only the
/// time in which an open line is not silent counts.
[[nodiscard]] Instant stop_overdue_at(const Parts& parts, const Transmission& stop);

/// The stop that can be transmitted next.
struct StopChoice {
  Transmission* stop;
  std::optional<Choice> before;  ///< what goes before it, because its drive is silent
};
[[nodiscard]] std::optional<StopChoice> choose_stop(Parts& parts, Instant now);

}  // namespace mbgate::bus
