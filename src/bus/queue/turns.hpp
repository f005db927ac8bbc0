// SPDX-License-Identifier: Apache-2.0
// Whose turn it is on a bus, and when. Nothing here changes anything.
#pragma once

#include <optional>

#include "bus/parts.hpp"

namespace mbgate::bus {

/// The job that goes next, when, and whom it passes over.
struct Choice {
  Job* job;
  Instant at;
  Job* passed_over = nullptr;
};

/// Which jobs may go while a stop waits; all of them where none does.
struct Bounds {
  const Job* before = nullptr;  ///< only those for its device that were accepted before it
  bool beside_stops = false;    ///< only those for devices that no waiting stop is for
};

/// Of those that wait, and of those that wait for their next try.
[[nodiscard]] std::optional<Choice> next_turn(Parts& parts, const Bounds& bounds, Instant now);
/// Of those that wait.
[[nodiscard]] std::optional<Choice> next_waiting(Parts& parts, const Bounds& bounds, Instant now);
/// When the bus is to be woken for it.
[[nodiscard]] Wake wake_for(const Parts& parts, const Job& job, Instant at);

/// Is there a place for one more job? Nothing comes between the transactions of a job, unless its
/// device must be left alone meanwhile, or a stop waits. One transaction that is to be repeated
/// keeps nobody waiting.
[[nodiscard]] bool has_place(const Parts& parts, Instant now);
[[nodiscard]] bool is_within(Parts& parts, const Bounds& bounds, const Job& job);

/// Until then its device boots, or owes an answer that could be taken for that to its request.
[[nodiscard]] Instant held_until(const Parts& parts, const Job& job);
[[nodiscard]] bool is_held_back(const Parts& parts, const Job& job, Instant now);
/// The first instant at which it may be transmitted.
[[nodiscard]] Instant ready_at(const Parts& parts, const Job& job);
/// The one that is transmitted when its turn has come: whether a question of the gateway's own is
/// needed is known only then. It is never the last transaction of a job. A stop asks nothing.
[[nodiscard]] std::size_t next_transaction(const Parts& parts, const Job& job);

}  // namespace mbgate::bus
