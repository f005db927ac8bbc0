// SPDX-License-Identifier: Apache-2.0
// Whose turn it is on a bus, and when.
#include <algorithm>
#include <bitset>

#include "bus/bus.hpp"

namespace mbgate::bus {

/// What was found while the waiting jobs are looked at.
struct Bus::Search {
  Instant soonest;  ///< anything may go
  std::optional<Choice> best;
  Job* waits_for_gap = nullptr;
  std::bitset<kAddresses> claimed;  ///< by jobs that wait for what is in flight to their device
  Bounds bounds;
  bool decided = false;
};

void Bus::pump(Instant now) {
  pumped_at_ = now;
  next_start_.reset();
  expire(now);
  end_over(now);
  watch_deadlines();
  if (!link_.is_open() || reopen_if_hung(now)) {
    wait_for_line();
    return;
  }
  if (serve_stops(now)) {
    return;
  }
  continue_running(now);
  while (occupied(now) < most_running_ && in_flight() < most_running_) {
    // A stop that waits now lets the writes to its device go first, and nothing goes before these.
    const auto choice = next_turn({queue_.first_stop()}, now);
    if (!choice) {
      return;
    }
    if (choice->at > now) {
      next_start_ = earlier(next_start_, Wake{choice->at, held_until(*choice->job) < choice->at});
      return;
    }
    if (!has_looked()) {
      return;
    }
    begin(*choice, now);
  }
}

// Nothing is transmitted before what already lies in the line was looked at: it may be the answer
// to an earlier request, or show that the line is not silent.
bool Bus::has_looked() {
  if (looking_ == Looking::no) {
    looking_ = Looking::asked;
    actions_.push(LookAtLine{});
  }
  return looking_ == Looking::done;
}

void Bus::begin(const Choice& choice, Instant now) {
  if (choice.passed_over != nullptr) {
    choice.passed_over->passed_over = true;
  }
  if (choice.job->is_waiting()) {
    queue_.take(*choice.job);
    running_.push_back(choice.job);
  }
  transmit(*choice.job, now);
}

void Bus::expire(Instant now) {
  for (Job* job = queue_.first_to_expire(); job != nullptr && now >= job->deadline;
       job = queue_.first_to_expire()) {
    queue_.remove(*job);
    ++counters_.expired;
    end_job(*job, Ending::expired);
  }
}

// Goes on with jobs of several transactions.
void Bus::continue_running(Instant now) {
  const Job* stop = queue_.first_stop();
  for (Job* job : running_) {
    if (job->in_flight) {
      continue;
    }
    if (stop != nullptr && job->address() != stop->address() && !job->is_broadcast()) {
      continue;  // the writes that the stop lets go first go before it
    }
    const Instant ready = ready_at(*job);
    if (is_between_tries(*job) && !is_held_back(*job, now)) {
      continue;  // next_turn() has it
    }
    if (now < ready) {
      next_start_ = earlier(next_start_, Wake{ready, held_until(*job) < ready});
    } else if (in_flight() < most_running_ && has_looked()) {
      transmit(*job, now);
    }
  }
}

std::size_t Bus::in_flight() const {
  return static_cast<std::size_t>(
      std::ranges::count_if(running_, [](const Job* job) { return job->in_flight; }));
}

// Nothing comes between the transactions of a job, unless its device must be left alone meanwhile,
// or a stop waits. One transaction that is to be repeated keeps nobody waiting.
std::size_t Bus::occupied(Instant now) {
  const bool stop_waits = queue_.first_stop() != nullptr;
  return static_cast<std::size_t>(std::ranges::count_if(running_, [&](const Job* job) {
    return job->in_flight || (!stop_waits && !is_between_tries(*job) && !is_held_back(*job, now));
  }));
}

bool Bus::is_held_back(const Job& job, Instant now) const {
  return !job.transactions[next_transaction(job)].is_broadcast() && held_until(job) > now;
}

std::optional<Bus::Choice> Bus::choose(const Bounds& bounds, Instant now) {
  Search search{std::max(now, line_.ready_at(Duration{0})), {}, nullptr, {}, bounds, false};
  const JobClass first = writes_in_row_ >= settings_.burst ? JobClass::read : JobClass::write;
  const JobClass second = first == JobClass::write ? JobClass::read : JobClass::write;
  if (bounds.before != nullptr) {
    look_for(JobClass::write, search, now);
    look_for(JobClass::read, search, now);
    return search.best;
  }
  look_for(first, search, now);
  if (!search.decided) {
    look_for(second, search, now);
  }
  return search.best;
}

// Jobs are looked at in the order of their turns. One that cannot go yet lets those to other
// devices pass: for as long as its device is held back or busy, but only once for its device's gap,
// because on a line that is never silent for so long its turn would never come.
void Bus::look_for(JobClass job_class, Search& search, Instant now) {
  queue_.visit_candidates(job_class, [&](Job& job) {
    const std::uint8_t address = job.transaction().address;
    if (!is_within(search.bounds, job) || had_its_turn(job, now)) {
      return false;
    }
    if (search.claimed[address] || !may_join(job)) {
      search.claimed.set(address);
      return false;
    }
    const Instant ready = std::max(now, ready_at(job));
    if (!search.best || ready < search.best->at) {
      search.best = Choice{&job, ready, search.waits_for_gap};
    }
    if (ready > search.soonest && held_until(job) < ready) {
      search.waits_for_gap = search.waits_for_gap != nullptr ? search.waits_for_gap : &job;
      search.decided = job.passed_over;
      return search.decided;
    }
    search.decided = ready == search.soonest;
    return search.decided;
  });
}

// Reads share a device; a write, and a job of several transactions, has it for itself; a broadcast
// has all of them. Nor does anything for the same device overtake a read that is being repeated;
// of broadcasts, those of the same client address do not.
bool Bus::may_join(const Job& job) const {
  const auto is_of_same = [&](const Job* other) { return other->source == job.source; };
  return std::ranges::none_of(running_, [&](const Job* other) {
    if (job.is_broadcast() && other->is_single_read() && is_between_tries(*other)) {
      return is_of_same(other) || std::ranges::any_of(other->followers, is_of_same);
    }
    const bool meets =
        other->address() == job.address() || job.is_broadcast() || other->is_broadcast();
    const bool shares =
        other->is_single_read() && job.is_single_read() && other->in_flight && other->tries == 1;
    return meets && !shares;
  });
}

// The device boots, or owes an answer that could be taken for that to another request.
Instant Bus::held_until(const Job& job) const {
  if (job.job_class == JobClass::stop) {
    return Instant::min();
  }
  const std::size_t next = next_transaction(job);
  const Transaction& transaction = job.transactions[next];
  const DeviceEntry& entry = devices_[transaction.address];
  const bool repeats_read = job.tries > 0 && next == job.current && transaction.request.is_read();
  const std::uint8_t function = transaction.request.function();
  return quarantines_ && !repeats_read
             ? std::max(entry.free_at, entry.health.held_until(function, entry.timing()))
             : entry.free_at;
}

Instant Bus::ready_at(const Job& job) const {
  if (job.job_class == JobClass::stop) {
    return line_.ready_for_stop_at();
  }
  const Transaction& transaction = job.transactions[next_transaction(job)];
  if (transaction.is_broadcast()) {
    return line_.ready_at(settings_.timing.gap);
  }
  const DeviceEntry& entry = devices_[transaction.address];
  return std::max(held_until(job), line_.ready_at(entry.timing().gap));
}

}  // namespace mbgate::bus
