// SPDX-License-Identifier: Apache-2.0
#include "bus/queue/scheduler.hpp"

#include <algorithm>
#include <bitset>
#include <utility>

namespace mbgate::bus {

Next Scheduler::next(Instant now) const {
  if (Job* stop = choose_stop(now)) {
    return next_stop(*stop, now);
  }
  const Next part = next_part(now);
  if (part.step == Next::Step::transmit || !has_place(now)) {
    return part;
  }
  const auto choice = next_turn(Passing::nothing, now);
  if (!choice) {
    return part;
  }
  if (choice->at() <= now) {
    return {Next::Step::transmit, {}, choice->job};
  }
  return {Next::Step::wait, earlier(choice->when, part.at)};
}

// Of the jobs of several transactions, nothing comes between these. What waits for its next try has
// its turn among the others, unless its device is held back.
Next Scheduler::next_part(Instant now) const {
  Next next;
  for (Job* running : parts_.transmissions.running()) {
    const bool has_turn = running->is_between_tries() && !is_held_back(parts_, *running, now);
    if (!parts_.transmissions.may_go_on(*running) || has_turn) {
      continue;
    }
    const Wake ready = ready_at(parts_, *running);
    if (now < ready.at) {
      next.at = earlier(next.at, ready);
    } else if (parts_.transmissions.has_room()) {
      return {Next::Step::transmit, {}, running};
    }
  }
  return next;
}

// May another job begin? Not between the transactions of a job, unless its device must be left
// alone meanwhile. A job with a single transaction that is to be repeated blocks no other.
bool Scheduler::has_place(Instant now) const {
  const auto occupied =
      std::ranges::count_if(parts_.transmissions.running(), [&](const Job* running) {
        return running->sent.in_flight ||
               (!running->is_between_tries() && !is_held_back(parts_, *running, now));
      });
  return static_cast<std::size_t>(occupied) < parts_.transmissions.room();
}

std::optional<Scheduler::Choice> Scheduler::next_turn(Passing passing, Instant now) const {
  const auto choice = next_waiting(passing, now);
  Job* job = next_repeated(passing, now);
  if (job == nullptr) {
    return choice;
  }
  const Choice repeated = ready(*job, now);
  return choice && goes_before_repeated(*choice, repeated) ? *choice : repeated;
}

// What is repeated is the first of its class, once lost time was paid back.
bool Scheduler::goes_before_repeated(const Choice& choice, const Choice& repeated) const {
  const bool is_of_first_class =
      is_write(choice.job->job_class) && repeated.job->is_read() && !reads_go_first();
  const bool is_paid = parts_.payback.is_due(repeated.at()) &&
                       !parts_.devices[choice.job->address()].is_silent() &&
                       (is_write(choice.job->job_class) || !is_write(repeated.job->job_class));
  return choice.at() < repeated.at() || (is_of_first_class && choice.when.ends_silence) ||
         (choice.at() == repeated.at() && (is_of_first_class || is_paid));
}

// The one that waits for its next try for longest.
Job* Scheduler::next_repeated(Passing passing, Instant now) const {
  Job* next = nullptr;
  for (Job* running : parts_.transmissions.running()) {
    if (running->is_between_tries() && !is_held_back(parts_, *running, now) &&
        parts_.transmissions.may_go_on(*running) &&
        (passing == Passing::nothing || may_pass_stops(*running)) &&
        (next == nullptr || running->sent.last_at < next->sent.last_at)) {
      next = running;
    }
  }
  return next;
}

// Jobs are looked at in the order of their turns. The first that only waits for the line goes next,
// also if it needs a longer silence than others (`gap`). One whose device is held back or busy lets
// those to other devices pass. While lost time is paid back, writes to devices that do not answer
// are the last of their class.
std::optional<Scheduler::Choice> Scheduler::next_waiting(Passing passing, Instant now) const {
  if (parts_.queue.size() == 0) {
    return std::nullopt;
  }
  const Instant soonest = std::max(now, parts_.line.ready_at(Duration{0}));
  std::optional<Choice> best;
  std::bitset<kAddresses> claimed;  // by jobs that wait for what is in flight to their device
  bool decided = false;
  bool pays = parts_.payback.is_due(now);
  const auto look = [&](Job& job) {
    if (pays && is_write(job.job_class) && parts_.devices[job.address()].is_silent()) {
      return false;
    }
    const std::uint8_t address = job.transaction().address;
    if (passing == Passing::stops && !may_pass_stops(job)) {
      return false;
    }
    if (claimed[address] || !may_join(job)) {
      claimed.set(address);
      return false;
    }
    const Choice choice = ready(job, now);
    if (!best || choice.at() < best->at()) {
      best = choice;
    }
    decided = choice.at() == soonest || choice.when.ends_silence;
    return decided;
  };
  const auto look_among = [&](JobClass job_class) {
    parts_.queue.visit_candidates(job_class, look);
    if (job_class == JobClass::write && !decided && std::exchange(pays, false)) {
      parts_.queue.visit_candidates(job_class, look);
    }
  };
  const JobClass first = reads_go_first() ? JobClass::read : JobClass::write;
  look_among(first);
  if (!decided) {
    look_among(first == JobClass::read ? JobClass::write : JobClass::read);
  }
  return best;
}

// Reads share a device; a write, and a job of several transactions, has it for itself; a broadcast
// has all of them. Nor does anything for the same device overtake a read that is being repeated;
// of broadcasts, those of the same client address do not.
bool Scheduler::may_join(const Job& job) const {
  const auto is_of_same = [&](const Job* other) { return other->source == job.source; };
  return std::ranges::none_of(parts_.transmissions.running(), [&](const Job* other) {
    if (job.is_broadcast() && other->is_single_read() && other->is_between_tries()) {
      return is_of_same(other) || std::ranges::any_of(other->sent.followers, is_of_same);
    }
    const bool meets =
        other->address() == job.address() || job.is_broadcast() || other->is_broadcast();
    const bool shares = other->is_single_read() && job.is_single_read() && other->sent.in_flight &&
                        other->sent.tries == 1;
    return meets && !shares;
  });
}

namespace {

// `next`: the transaction that is transmitted when the turn of the job has come.
Instant held_until(const Parts& parts, const Job& job, std::size_t next) {
  const Duration recently = parts.settings.timing.probe_interval;
  if (job.is_stop()) {
    return is_given_up(parts, job) ? parts.payback.until(job.address(), recently) : Instant::min();
  }
  const Transaction& transaction = job.transactions[next];
  const DeviceEntry& entry = parts.devices[transaction.address];
  const bool repeats_read =
      job.sent.tries > 0 && next == job.current && transaction.request.is_read();
  const Instant free =
      entry.is_silent() && !is_write(job.job_class)
          ? std::max(entry.free_at, parts.payback.until(transaction.address, recently))
          : entry.free_at;
  return parts.quarantines()
             ? std::max(free, entry.hold.until(transaction.request, entry.in_force(), repeats_read))
             : free;
}

}  // namespace

Instant held_until(const Parts& parts, const Job& job) {
  return held_until(parts, job, next_transaction(parts, job));
}

bool is_held_back(const Parts& parts, const Job& job, Instant now) {
  const std::size_t next = next_transaction(parts, job);
  return !job.transactions[next].is_broadcast() && held_until(parts, job, next) > now;
}

Wake ready_at(const Parts& parts, const Job& job) {
  if (job.is_stop()) {
    return {parts.line.ready_for_stop_at(), true};
  }
  const std::size_t next = next_transaction(parts, job);
  const Transaction& transaction = job.transactions[next];
  const Instant held = held_until(parts, job, next);
  const bool is_broadcast = transaction.is_broadcast();
  const drive::DeviceTiming& timing =
      is_broadcast ? parts.settings.timing : parts.devices[transaction.address].in_force();
  const Instant silent_at = parts.line.ready_at(timing.gap);
  const Instant at = is_broadcast ? silent_at : std::max(held, silent_at);
  return {at, held < at};
}

// What is offline does not hear a broadcast, and is not asked before it.
std::size_t next_transaction(const Parts& parts, const Job& job) {
  const auto is_needless = [&](const Transaction& question) {
    const DeviceEntry& entry = parts.devices[question.address];
    return job.is_stop() || entry.setting_known ||
           (job.is_broadcast() && entry.health.is_offline());
  };
  std::size_t next = job.current;
  while (job.transactions[next].must_hold != nullptr && is_needless(job.transactions[next])) {
    ++next;
  }
  return next;
}

Job* in_the_way_of(const Parts& parts, const Job& stop) {
  const auto running = parts.transmissions.running();
  const auto found = std::ranges::find_if(running, [&](const Job* it) {
    return it->sent.in_flight &&
           (parts.quarantines() || (it->is_stop() && it->address() == stop.address()));
  });
  return found == running.end() ? nullptr : *found;
}

Duration time_before_stop(const Parts& parts, const Transaction& sent) {
  constexpr int kSafely = 2;  // times the longest answer of late to ordinary registers
  const DeviceEntry& entry = parts.devices[sent.address];
  return entry.in_force().response_wait +
         std::max(parts.settings.stop_wait, kSafely * entry.hold.pace().longest_ordinary());
}

bool is_given_up(const Parts& parts, const Job& stop) {
  return !stop.is_broadcast() && stop.sent.tries == 0 &&
         parts.devices[stop.address()].stops_given_up;
}

bool may_cut(const Parts& parts, const Job& stop, Instant now) {
  return !is_given_up(parts, stop) && !parts.acknowledged.has(stop, now);
}

Instant stop_overdue_at(const Parts& parts, const Job& stop) {
  const LineSilence* silence = parts.line.silence();
  return silence == nullptr ? Instant::max()
                            : std::max(stop.sent.waits_since, silence->busy_since()) +
                                  stop_deadline(parts.settings);
}

}  // namespace mbgate::bus
