// SPDX-License-Identifier: Apache-2.0
// Stops to drives that answer none: who goes between them, so that they do not have the bus for
// themselves.
#include <algorithm>

#include "bus/bus.hpp"

namespace mbgate::bus {

// A device that left its last stop unanswered does not get the next one before another device had a
// turn: a client that repeats a stop to a dead drive would have the bus for itself. But on a line
// that is never silent that turn would never come.
bool Bus::gives_way(const Job& stop, Instant now) const {
  return !stop.is_broadcast() && devices_[stop.address()].last_stop_turn > other_turn_ &&
         now < stop_overdue_at(stop);
}

// Since its device left its last stop unanswered, something else was transmitted, if only another
// stop: of those it lets no more go first.
bool Bus::was_passed(const Job& stop) const {
  const bool was_last = last_address_ == stop.address();
  return devices_[stop.address()].last_stop_turn < (was_last ? turn_of_others_ : turn_);
}

// Nothing that runs is cut for a stop to a device that is offline and was given up.
bool Bus::waits_patiently(const Job& stop) const {
  const DeviceEntry& entry = devices_[stop.address()];
  return !stop.is_broadcast() && stop.tries == 0 && entry.stops_given_up &&
         entry.health.is_offline();
}

// What goes between two tries of a stop, if it can begin soon enough.
std::optional<Bus::Choice> Bus::turn_before(const Job& stop, Instant now) {
  const Job* waits = queue_.find_stop([this](const Job& it) { return must_let_writes_go(it); });
  const Bounds bounds{waits, true};
  const Instant limit = std::max(stop.waits_since, line_.ready_for_stop_at()) + settings_.stop_wait;
  std::optional<Choice> turn;
  const auto part = std::ranges::find_if(running_, [&](const Job* job) {
    return !job->in_flight && !is_between_tries(*job) && !is_held_back(*job, now) &&
           is_within(bounds, *job);
  });
  if (part != running_.end()) {
    turn = Choice{*part, std::max(now, ready_at(**part))};
  } else {
    turn = next_turn(bounds, now);
  }
  return turn && turn->at <= limit ? turn : std::nullopt;
}

}  // namespace mbgate::bus
