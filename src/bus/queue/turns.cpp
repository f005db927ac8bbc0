// SPDX-License-Identifier: Apache-2.0
#include "bus/queue/turns.hpp"

#include <algorithm>
#include <bitset>

namespace mbgate::bus {
namespace {

/// What was found while the waiting jobs are looked at.
struct Search {
  Instant soonest;  ///< anything may go
  std::optional<Choice> best;
  Job* waits_for_gap = nullptr;
  std::bitset<kAddresses> claimed;  ///< by jobs that wait for what is in flight to their device
  Passing passing;
  bool decided = false;
};

// Reads share a device; a write, and a job of several transactions, has it for itself; a broadcast
// has all of them. Nor does anything for the same device overtake a read that is being repeated;
// of broadcasts, those of the same client address do not.
bool may_join(const Parts& parts, const Job& job) {
  const auto is_of_same = [&](const Job* other) { return other->source == job.source; };
  return std::ranges::none_of(parts.transmissions.running(), [&](const Transmission* running) {
    const Job& other = *running->leader;
    if (job.is_broadcast() && other.is_single_read() && running->is_between_tries()) {
      return is_of_same(&other) || std::ranges::any_of(running->followers, is_of_same);
    }
    const bool meets =
        other.address() == job.address() || job.is_broadcast() || other.is_broadcast();
    const bool shares =
        other.is_single_read() && job.is_single_read() && running->in_flight && running->tries == 1;
    return meets && !shares;
  });
}

// Jobs are looked at in the order of their turns. One that cannot go yet lets those to other
// devices pass: for as long as its device is held back or busy, but only once for its device's gap,
// because on a line that is never silent for so long its turn would never come.
void look_for(Parts& parts, JobClass job_class, Search& search, Instant now) {
  parts.queue.visit_candidates(job_class, [&](Job& job) {
    const std::uint8_t address = job.transaction().address;
    if (search.passing == Passing::stops && !may_pass_stops(parts, job, now)) {
      return false;
    }
    if (search.claimed[address] || !may_join(parts, job)) {
      search.claimed.set(address);
      return false;
    }
    const Instant ready = std::max(now, ready_at(parts, job));
    if (!search.best || ready < search.best->at) {
      search.best = Choice{&job, ready, search.waits_for_gap};
    }
    if (ready > search.soonest && held_until(parts, job) < ready) {
      search.waits_for_gap = search.waits_for_gap != nullptr ? search.waits_for_gap : &job;
      search.decided = job.passed_over;
      return search.decided;
    }
    search.decided = ready == search.soonest;
    return search.decided;
  });
}

// The one that waits for its next try for longest.
Job* next_repeated(Parts& parts, Passing passing, Instant now) {
  const Transmission* next = nullptr;
  for (const Transmission* running : parts.transmissions.running()) {
    if (running->is_between_tries() && !is_held_back(parts, *running->leader, now) &&
        parts.transmissions.may_go_on(*running) &&
        (passing == Passing::nothing || may_pass_stops(parts, *running->leader, now)) &&
        (next == nullptr || running->last_sent < next->last_sent)) {
      next = running;
    }
  }
  return next == nullptr ? nullptr : next->leader;
}

bool reads_go_first(const Parts& parts) {
  return parts.turns.writes_in_row() >= parts.settings.burst;
}

// What is repeated is the first of its class, once lost time was paid back.
bool goes_before_repeated(const Parts& parts, const Choice& choice, const Job& repeated,
                          Instant ready) {
  const bool is_of_first_class =
      is_write(choice.job->job_class) && repeated.is_read() && !reads_go_first(parts);
  const bool is_paid =
      parts.payback.is_due(ready) && !parts.devices[choice.job->address()].is_silent();
  return choice.at < ready || (choice.at == ready && (is_of_first_class || is_paid));
}

std::optional<Choice> next_waiting(Parts& parts, Passing passing, Instant now) {
  Search search{std::max(now, parts.line.ready_at(Duration{0})), {}, nullptr, {}, passing, false};
  const JobClass first = reads_go_first(parts) ? JobClass::read : JobClass::write;
  const JobClass second = first == JobClass::write ? JobClass::read : JobClass::write;
  look_for(parts, first, search, now);
  if (!search.decided) {
    look_for(parts, second, search, now);
  }
  return search.best;
}

}  // namespace

std::optional<Choice> next_turn(Parts& parts, Passing passing, Instant now) {
  const auto choice = next_waiting(parts, passing, now);
  Job* repeated = next_repeated(parts, passing, now);
  if (repeated == nullptr) {
    return choice;
  }
  const Instant ready = std::max(now, ready_at(parts, *repeated));
  return choice && goes_before_repeated(parts, *choice, *repeated, ready) ? choice
                                                                          : Choice{repeated, ready};
}

Wake wake_for(const Parts& parts, const Job& job, Instant at) {
  return {at, held_until(parts, job) < at};
}

bool has_place(const Parts& parts, Instant now) {
  const auto occupied =
      std::ranges::count_if(parts.transmissions.running(), [&](const Transmission* running) {
        return running->in_flight ||
               (!running->is_between_tries() && !is_held_back(parts, *running->leader, now));
      });
  return static_cast<std::size_t>(occupied) < parts.transmissions.room();
}

bool may_pass_stops(Parts& parts, const Job& job, Instant now) {
  return job.job_class == JobClass::read ||
         (!job.is_broadcast() && parts.stops.find([&](const Transmission& stop) {
           return (stop.leader->address() == job.address() || stop.leader->is_broadcast()) &&
                  !parts.acknowledged.has(*stop.leader, now);
         }) == nullptr);
}

Instant held_until(const Parts& parts, const Job& job) {
  if (job.job_class == JobClass::stop) {
    return Instant::min();
  }
  const std::size_t next = next_transaction(parts, job);
  const Transaction& transaction = job.transactions[next];
  const DeviceEntry& entry = parts.devices[transaction.address];
  const bool repeats_read = job.leads != nullptr && job.leads->tries > 0 && next == job.current &&
                            transaction.request.is_read();
  const std::uint8_t function = transaction.request.function();
  const Duration recently = parts.settings.timing.probe_interval;
  const Instant free =
      entry.is_silent() && !transaction.is_broadcast()
          ? std::max(entry.free_at, parts.payback.until(transaction.address, recently))
          : entry.free_at;
  return parts.quarantines() && !repeats_read
             ? std::max(free, entry.hold.until(function, entry.timing()))
             : free;
}

bool is_held_back(const Parts& parts, const Job& job, Instant now) {
  return !job.transactions[next_transaction(parts, job)].is_broadcast() &&
         held_until(parts, job) > now;
}

Instant ready_at(const Parts& parts, const Job& job) {
  if (job.job_class == JobClass::stop) {
    return parts.line.ready_for_stop_at();
  }
  const Transaction& transaction = job.transactions[next_transaction(parts, job)];
  if (transaction.is_broadcast()) {
    return parts.line.ready_at(parts.settings.timing.gap);
  }
  const DeviceEntry& entry = parts.devices[transaction.address];
  return std::max(held_until(parts, job), parts.line.ready_at(entry.timing().gap));
}

std::size_t next_transaction(const Parts& parts, const Job& job) {
  std::size_t next = job.current;
  while (job.transactions[next].must_hold != nullptr &&
         (job.job_class == JobClass::stop ||
          parts.devices[job.transactions[next].address].setting_known)) {
    ++next;
  }
  return next;
}

}  // namespace mbgate::bus
