// SPDX-License-Identifier: Apache-2.0
// Requests of one transaction that are to be repeated: meanwhile each other device may have a turn.
#include <algorithm>

#include "bus/bus.hpp"

namespace mbgate::bus {

bool Bus::is_between_tries(const Job& job) {
  return job.tries > 0 && !job.in_flight && job.transactions.size() == 1;
}

bool Bus::is_within(const Bounds& bounds, const Job& job) {
  if (bounds.before != nullptr) {
    return (job.transaction().address == bounds.before->address() || job.is_broadcast()) &&
           job.sequence < bounds.before->sequence;
  }
  return !bounds.beside_stops || (!job.is_broadcast() && queue_.find_stop([&](const Job& stop) {
    return stop.address() == job.address() || stop.is_broadcast();
  }) == nullptr);
}

// The one that waits for its next try for longest.
Job* Bus::next_repeated(const Bounds& bounds, Instant now) {
  Job* next = nullptr;
  for (Job* job : running_) {
    if (is_between_tries(*job) && !is_held_back(*job, now) && is_within(bounds, *job) &&
        (next == nullptr || job->turn < next->turn)) {
      next = job;
    }
  }
  return next;
}

// Between two tries each other device has one turn at most.
bool Bus::had_its_turn(const Job& job, Instant now) const {
  const std::uint64_t last_turn = devices_[job.transaction().address].last_turn;
  return std::ranges::any_of(running_, [&](const Job* repeated) {
    return is_between_tries(*repeated) && last_turn > repeated->turn &&
           !is_held_back(*repeated, now);
  });
}

std::optional<Bus::Choice> Bus::next_turn(const Bounds& bounds, Instant now) {
  const auto choice = choose(bounds, now);
  Job* repeated = next_repeated(bounds, now);
  if (repeated == nullptr) {
    return choice;
  }
  const Instant ready = std::max(now, ready_at(*repeated));
  return choice && choice->at <= ready ? choice : Choice{repeated, ready};
}

}  // namespace mbgate::bus
