// SPDX-License-Identifier: Apache-2.0
// The order among stops, and what is sent between two stops to drives that do not answer.
#include <algorithm>

#include "bus/queue/scheduler.hpp"

namespace mbgate::bus {
namespace {

// It has answered neither its last transmission nor the one before; or it has refused its last
// stop.
bool does_not_obey(const DeviceEntry& entry) {
  return entry.failed_stop ||
         ((entry.stop_unanswered || entry.is_silent()) && !entry.health.answered_before_last());
}

// Of two stops to drives that do not answer, the second lets something else go first, and so does
// one that repeats an acknowledged stop.
bool has_turn_before(const Parts& parts, const Job& stop, Instant now) {
  const auto last = parts.last_sent.stop();
  return last && parts.transmissions.has_room() &&
         (does_not_obey(parts.devices[*last]) || parts.acknowledged.has(stop, now));
}

// The time that the stop has waited behind a transmission that nobody answered does not count: two
// stops in turn to a dead drive, and a pause after each (`settle`), would leave no turn to others.
Instant could_go_at(const Parts& parts, const Job& stop) {
  return std::max(
      {stop.sent.waits_since, parts.line.ready_for_stop_at(), parts.last_sent.ended_at()});
}

}  // namespace

// Whoever repeats a stop to a dead drive, or one that was acknowledged, must not have the line for
// itself. On a line that is never silent the turn of others would never come.
bool Scheduler::gives_way(const Job& stop, Instant now) const {
  const bool disobeys = !stop.is_broadcast() && does_not_obey(parts_.devices[stop.address()]);
  return (disobeys || parts_.acknowledged.has(stop, now)) && now < stop_overdue_at(parts_, stop);
}

// Stops to drives that answer go first.
Job* Scheduler::choose_stop(Instant now) const {
  const auto can_go = [&](const Job& stop) {
    return in_the_way_of(parts_, stop) == nullptr && held_until(parts_, stop) <= now;
  };
  Job* urgent =
      parts_.stops.find([&](const Job& stop) { return can_go(stop) && !gives_way(stop, now); });
  return urgent != nullptr ? urgent : parts_.stops.find(can_go);
}

// Where the line is never silent there is nothing to lose: the stop is transmitted all the same,
// but not repeated so.
Next Scheduler::next_stop(Job& stop, Instant now) const {
  if (gives_way(stop, now) && has_turn_before(parts_, stop, now)) {
    if (const auto turn = turn_before(stop, now)) {
      return turn->at() > now ? Next{Next::Step::wait, turn->when}
                              : Next{Next::Step::transmit, {}, turn->job};
    }
  }
  if (stop.is_abandoned()) {
    return {Next::Step::cancel, {}, &stop};
  }
  const Instant silent_at = parts_.line.ready_for_stop_at();
  if (silent_at <= now) {
    return {Next::Step::transmit, {}, &stop};
  }
  const Instant overdue_at = std::max(stop_overdue_at(parts_, stop), parts_.line.possible_at());
  if (overdue_at > now) {
    return {Next::Step::wait, Wake{std::min(silent_at, overdue_at), silent_at <= overdue_at}};
  }
  const auto step = stop.sent.tries > 0 ? Next::Step::give_up : Next::Step::transmit;
  return {step, {}, &stop};
}

// What goes between two tries of a stop, if it can begin soon enough.
std::optional<Scheduler::Choice> Scheduler::turn_before(const Job& stop, Instant now) const {
  const Instant limit = could_go_at(parts_, stop) + parts_.settings.stop_wait;
  std::optional<Choice> turn;
  const auto running = parts_.transmissions.running();
  const auto part = std::ranges::find_if(running, [&](const Job* job) {
    return parts_.transmissions.may_go_on(*job) && !job->is_between_tries() &&
           !is_held_back(parts_, *job, now) && may_pass_stops(*job);
  });
  if (part != running.end()) {
    turn = ready(**part, now);
  } else {
    turn = next_turn(Passing::stops, now);
  }
  return turn && turn->at() <= limit ? turn : std::nullopt;
}

// Reads may, for one may show that what came was no echo, and what is for devices that no waiting
// stop is for.
bool Scheduler::may_pass_stops(const Job& job) const {
  return job.job_class == JobClass::read ||
         (!job.is_broadcast() && parts_.stops.find([&](const Job& stop) {
           return stop.address() == job.address() || stop.is_broadcast();
         }) == nullptr);
}

}  // namespace mbgate::bus
