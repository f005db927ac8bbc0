// SPDX-License-Identifier: Apache-2.0
#include "bus/queue/stop_order.hpp"

#include <algorithm>

namespace mbgate::bus {
namespace {

// When the next transmission for the writes that go before it may begin; nothing: not before others
// of other devices.
std::optional<Instant> next_before(Parts& parts, const Job& stop, Instant now) {
  const auto running = parts.transmissions.running();
  const auto own = std::ranges::find_if(running, [&](const Transmission* transmission) {
    const Job& job = *transmission->leader;
    return job.address() == stop.address() || job.is_broadcast();
  });
  if (own != running.end()) {
    return ready_at(parts, *(*own)->leader);
  }
  const auto choice = next_waiting(parts, {&stop}, now);
  return choice ? std::optional(ready_at(parts, *choice->job)) : std::nullopt;
}

// A device that left its last stop unanswered does not get the next one before another device had a
// turn: a client that repeats a stop to a dead drive would have the bus for itself. Nor does a stop
// go that only repeats an acknowledged one, while the last transmission was a stop. But on a line
// that is never silent that turn would never come.
bool gives_way(const Parts& parts, const Transmission& stop, Instant now) {
  const Job& job = *stop.leader;
  const bool was_unanswered = !job.is_broadcast() && parts.devices[job.address()].last_stop_turn >
                                                         parts.turns.last_but_stops();
  const bool repeats = parts.turns.was_stop_last() && parts.acknowledged.has(job, now);
  return (was_unanswered || repeats) && now < stop_overdue_at(parts, stop);
}

// Since its device left its last stop unanswered, something else was transmitted, if only another
// stop: of those it lets no more go first.
bool was_passed(const Parts& parts, const Job& stop) {
  const std::uint8_t address = stop.address();
  return parts.devices[address].last_stop_turn < parts.turns.last_but_to(address);
}

// When nothing but what is let go before it holds the stop any more. For how long it waited behind
// a transmission that nobody answered does not count: two stops in turn to a dead drive, and a
// pause after each (`settle`), would leave no turn to others.
Instant could_go_at(const Parts& parts, const Transmission& stop) {
  return std::max({stop.waits_since, parts.line.ready_for_stop_at(), parts.turns.last_end()});
}

// What goes between two tries of a stop, if it can begin soon enough.
std::optional<Choice> turn_before(Parts& parts, const Transmission& stop, Instant now) {
  const Transmission* waits = parts.stops.find(
      [&](const Transmission& it) { return must_let_writes_go(parts, *it.leader); });
  const Bounds bounds{waits == nullptr ? nullptr : waits->leader, true};
  const Instant limit = could_go_at(parts, stop) + parts.settings.stop_wait;
  std::optional<Choice> turn;
  const auto running = parts.transmissions.running();
  const auto part = std::ranges::find_if(running, [&](const Transmission* transmission) {
    return parts.transmissions.may_go_on(*transmission) && !transmission->is_between_tries() &&
           !is_held_back(parts, *transmission->leader, now) &&
           is_within(parts, bounds, *transmission->leader, now);
  });
  if (part != running.end()) {
    turn = Choice{(*part)->leader, std::max(now, ready_at(parts, *(*part)->leader))};
  } else {
    turn = next_turn(parts, bounds, now);
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
    // A broadcast waits for nobody's writes.
    return stopped && (device.stop_cancels || stop.is_broadcast()) &&
           std::ranges::any_of(write.transactions, reaches);
  };
  return std::ranges::any_of(parts.devices.devices(), stops_device);
}

bool goes_before(const Job& write, const Job& stop) {
  return is_write(write.job_class) && write.sequence < stop.sequence &&
         (write.is_broadcast() || write.address() == stop.address());
}

bool lets_writes_go(const Parts& parts, const Job& stop) {
  return !stop.is_broadcast() && !parts.devices[stop.address()].device->stop_cancels;
}

bool must_let_writes_go(const Parts& parts, const Job& stop) {
  return lets_writes_go(parts, stop) &&
         (parts.queue.write_waits_before(stop.address(), stop.sequence) ||
          std::ranges::any_of(parts.transmissions.running(), [&](const Transmission* running) {
            return !running->in_flight && goes_before(*running->leader, stop);
          }));
}

Duration held_by(const Parts& parts, const Transmission& stop, Instant ready) {
  return std::max(ready - could_go_at(parts, stop), Duration{0});
}

Transmission* in_the_way_of(const Parts& parts, const Job& stop) {
  const bool write_goes_first = must_let_writes_go(parts, stop);
  const auto running = parts.transmissions.running();
  const auto occupying = std::ranges::find_if(running, [&](const Transmission* it) {
    return it->in_flight && it->leader->address() == stop.address() &&
           (write_goes_first || it->leader->job_class != JobClass::read);
  });
  if (occupying != running.end()) {
    return *occupying;
  }
  return parts.transmissions.has_room() ? nullptr : parts.transmissions.first_in_flight();
}

// A write that is let go first has the line as the stop itself would, and as much time for its
// answer as any running transaction; but while such writes are held back (quarantine, `gap`, boot
// time, `settle`) they hold the stop for `stop_wait` at most, all together; and where the line is
// never silent, no longer than the stop's deadline.
bool is_held_too_long(Parts& parts, const Transmission& stop, Instant now) {
  const Job& job = *stop.leader;
  if (!must_let_writes_go(parts, job) || in_the_way_of(parts, job) != nullptr) {
    return false;
  }
  const auto next = next_before(parts, job, now);
  return !next || now >= stop_overdue_at(parts, stop) ||
         stop.held_by_writes + held_by(parts, stop, *next) > parts.settings.stop_wait;
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

bool waits_patiently(const Parts& parts, const Transmission& stop, Instant now) {
  return is_given_up(parts, stop) || parts.acknowledged.has(*stop.leader, now);
}

Transmission* next_stop(Parts& parts, Instant now) {
  const auto may_go = [&](const Transmission& it) {
    return !must_let_writes_go(parts, *it.leader);
  };
  const auto cuts = [&](const Transmission& it) {
    return may_go(it) && !waits_patiently(parts, it, now);
  };
  Transmission* stop = parts.stops.find(cuts);
  stop = stop != nullptr ? stop : parts.stops.find(may_go);
  return stop != nullptr ? stop : parts.stops.first();
}

Instant stop_overdue_at(const Parts& parts, const Transmission& stop) {
  const LineSilence* silence = parts.line.silence();
  return silence == nullptr
             ? Instant::max()
             : std::max(stop.waits_since, silence->busy_since()) + stop_deadline(parts.settings);
}

std::optional<StopChoice> choose_stop(Parts& parts, Instant now) {
  const auto can_go = [&](const Transmission& stop) {
    return !must_let_writes_go(parts, *stop.leader) &&
           in_the_way_of(parts, *stop.leader) == nullptr;
  };
  const auto is_new = [&](const Transmission& stop) {
    return can_go(stop) && !gives_way(parts, stop, now);
  };
  const auto goes_first = [&](const Transmission& stop) {
    return is_new(stop) || (can_go(stop) && !parts.acknowledged.has(*stop.leader, now) &&
                            was_passed(parts, *stop.leader));
  };
  const bool others_wait = parts.stops.find(is_new) != nullptr;
  Transmission* stop = others_wait ? parts.stops.find(goes_first) : parts.stops.find(can_go);
  if (stop == nullptr) {
    return std::nullopt;
  }
  return StopChoice{stop, others_wait ? std::nullopt : turn_before(parts, *stop, now)};
}

}  // namespace mbgate::bus
