// SPDX-License-Identifier: Apache-2.0
#include "bus/queue/stop_order.hpp"

#include <algorithm>

namespace mbgate::bus {
namespace {

bool does_not_answer(const DeviceEntry& entry) {
  return entry.is_silent() || entry.stop_unanswered;
}

// Whoever repeats a stop to a dead drive, or one that was acknowledged, must not have the line for
// itself. On a line that is never silent the turn of others would never come.
bool gives_way(const Parts& parts, const Transmission& stop, Instant now) {
  const Job& job = *stop.leader;
  const bool is_silent = !job.is_broadcast() && does_not_answer(parts.devices[job.address()]);
  return (is_silent || parts.acknowledged.has(job, now)) && now < stop_overdue_at(parts, stop);
}

// Of two stops to drives that do not answer, the second lets something else go first, and so does
// one that repeats an acknowledged stop.
bool has_turn_before(const Parts& parts, const Transmission& stop, Instant now) {
  const auto last = parts.turns.last_stop();
  return last && parts.transmissions.has_room() &&
         (does_not_answer(parts.devices[*last]) || parts.acknowledged.has(*stop.leader, now));
}

// The time that the stop has waited behind a transmission that nobody answered does not count: two
// stops in turn to a dead drive, and a pause after each (`settle`), would leave no turn to others.
Instant could_go_at(const Parts& parts, const Transmission& stop) {
  return std::max({stop.waits_since, parts.line.ready_for_stop_at(), parts.turns.last_end()});
}

// What goes between two tries of a stop, if it can begin soon enough.
std::optional<Choice> turn_before(Parts& parts, const Transmission& stop, Instant now) {
  const Instant limit = could_go_at(parts, stop) + parts.settings.stop_wait;
  std::optional<Choice> turn;
  const auto running = parts.transmissions.running();
  const auto part = std::ranges::find_if(running, [&](const Transmission* transmission) {
    return parts.transmissions.may_go_on(*transmission) && !transmission->is_between_tries() &&
           !is_held_back(parts, *transmission->leader, now) &&
           may_pass_stops(parts, *transmission->leader, now);
  });
  if (part != running.end()) {
    turn = Choice{(*part)->leader, std::max(now, ready_at(parts, *(*part)->leader))};
  } else {
    turn = next_turn(parts, Passing::stops, now);
  }
  return turn && turn->at <= limit ? turn : std::nullopt;
}

}  // namespace

bool is_stopped_by(const Parts& parts, const Job& stop, const Job& write) {
  if (!is_write(write.job_class) || write.sequence > stop.sequence) {
    return false;
  }
  const auto stops_device = [&](const drive::Device& device) {
    const auto reaches = [&](const Transaction& transaction) {
      return device.is_addressed_by(transaction.address, transaction.broadcast);
    };
    const bool stopped = std::ranges::any_of(stop.transactions, [&](const Transaction& it) {
      return reaches(it) && (!it.is_broadcast() || device.is_stop(it.request));
    });
    return stopped && std::ranges::any_of(write.transactions, reaches);
  };
  return std::ranges::any_of(parts.devices.devices(), stops_device);
}

Transmission* in_the_way_of(const Parts& parts, const Job& stop) {
  const auto running = parts.transmissions.running();
  const auto found = std::ranges::find_if(running, [&](const Transmission* it) {
    return it->in_flight &&
           (parts.quarantines() || (it->is_stop() && it->leader->address() == stop.address()));
  });
  return found == running.end() ? nullptr : *found;
}

Duration time_before_stop(const Parts& parts, const Transaction& sent) {
  constexpr int kSafely = 2;  // times the longest answer of late
  const DeviceEntry& entry = parts.devices[sent.address];
  return entry.timing().response_wait +
         std::max(parts.settings.stop_wait, kSafely * entry.hold.longest_answer());
}

bool is_given_up(const Parts& parts, const Transmission& stop) {
  const DeviceEntry& entry = parts.devices[stop.leader->address()];
  return !stop.leader->is_broadcast() && stop.tries == 0 && entry.stops_given_up &&
         entry.health.is_offline();
}

Instant held_until(const Parts& parts, const Transmission& stop) {
  return is_given_up(parts, stop)
             ? parts.payback.until(stop.leader->address(), parts.settings.timing.probe_interval)
             : Instant::min();
}

bool waits_patiently(const Parts& parts, const Transmission& stop, Instant now) {
  return is_given_up(parts, stop) || parts.acknowledged.has(*stop.leader, now);
}

Instant stop_overdue_at(const Parts& parts, const Transmission& stop) {
  const LineSilence* silence = parts.line.silence();
  return silence == nullptr
             ? Instant::max()
             : std::max(stop.waits_since, silence->busy_since()) + stop_deadline(parts.settings);
}

std::optional<StopChoice> choose_stop(Parts& parts, Instant now) {
  const auto can_go = [&](const Transmission& stop) {
    return in_the_way_of(parts, *stop.leader) == nullptr && held_until(parts, stop) <= now;
  };
  Transmission* urgent = parts.stops.find(
      [&](const Transmission& stop) { return can_go(stop) && !gives_way(parts, stop, now); });
  if (urgent != nullptr) {
    return StopChoice{urgent, std::nullopt};
  }
  Transmission* stop = parts.stops.find(can_go);
  if (stop == nullptr) {
    return std::nullopt;
  }
  return StopChoice{
      stop, has_turn_before(parts, *stop, now) ? turn_before(parts, *stop, now) : std::nullopt};
}

}  // namespace mbgate::bus
