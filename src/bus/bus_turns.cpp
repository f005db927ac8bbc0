// SPDX-License-Identifier: Apache-2.0
// Whose turn it is on a bus, and when.
#include <algorithm>

#include "bus/bus.hpp"

namespace mbgate::bus {

void Bus::pump(Instant now) {
  pumped_at_ = now;
  next_start_.reset();
  expire(now);
  if (state_ != State::open) {
    return;
  }
  continue_running(now);
  while (running_.size() < most_running_) {
    const auto choice = choose(now);
    if (!choice) {
      return;
    }
    if (choice->at > now) {
      next_start_ = earlier(next_start_, choice->at);
      return;
    }
    if (choice->passed_over != nullptr) {
      choice->passed_over->passed_over = true;
    }
    queue_.take(*choice->job);
    running_.push_back(choice->job);
    transmit(*choice->job, now);
  }
}

void Bus::expire(Instant now) {
  for (Job* job = queue_.first_to_expire(); job != nullptr && now >= job->deadline;
       job = queue_.first_to_expire()) {
    queue_.remove(*job);
    ++counters_.expired;
    end_job(*job, Ending::expired);
  }
}

// Repeats what failed, and goes on with jobs of several transactions.
void Bus::continue_running(Instant now) {
  for (std::size_t at = 0; at < running_.size();) {
    Job& job = *running_[at];
    if (!job.in_flight && end_if_over(job, now)) {
      continue;  // it is no longer among the running ones
    }
    ++at;
    if (job.in_flight) {
      continue;
    }
    const Instant ready = ready_at(job.transaction());
    if (now >= ready) {
      transmit(job, now);
    } else {
      next_start_ = earlier(next_start_, std::min(ready, job.deadline));
    }
  }
}

// May the job not be transmitted any further?
bool Bus::end_if_over(Job& job, Instant now) {
  const bool withdrawn = job.abandoned || stopping_;
  if (!withdrawn && now < job.deadline) {
    return false;
  }
  counters_.expired += withdrawn ? 0U : 1U;
  finish(job, withdrawn ? Ending::cancelled : Ending::expired);
  return true;
}

// Jobs are looked at in the order of their turns. One that cannot go yet lets those to other
// devices pass: for as long as its device is held back or busy, but only once for its device's gap,
// because on a line that is never silent for so long its turn would never come.
std::optional<Bus::Choice> Bus::choose(Instant now) {
  const Instant soonest = std::max(now, line_.ready_at(Duration{0}));
  std::optional<Choice> best;
  Job* waits_for_gap = nullptr;
  std::bitset<kAddresses> claimed;  // by jobs that wait for what is in flight to their device
  queue_.visit_candidates([&](Job& job) {
    const Transaction& transaction = job.transaction();
    if (claimed[transaction.address] || !may_join(job)) {
      claimed.set(transaction.address);
      return false;
    }
    const Instant ready = std::max(now, ready_at(transaction));
    if (!best || ready < best->at) {
      best = Choice{&job, ready, waits_for_gap};
    }
    if (ready > soonest && devices_[transaction.address].free_at < ready) {
      waits_for_gap = waits_for_gap != nullptr ? waits_for_gap : &job;
      return job.passed_over;
    }
    return ready == soonest;
  });
  return best;
}

// Reads share a device; a write, and a job of several transactions, has it for itself. Nor does
// anybody overtake a read that is being repeated.
bool Bus::may_join(const Job& job) const {
  return std::ranges::none_of(running_, [&](const Job* other) {
    const bool shares =
        other->is_single_read() && job.is_single_read() && other->in_flight && other->tries == 1;
    return other->transactions.front().address == job.transactions.front().address && !shares;
  });
}

Instant Bus::ready_at(const Transaction& transaction) const {
  if (transaction.is_broadcast()) {
    return line_.ready_at(settings_.timing.gap);
  }
  const DeviceEntry& entry = devices_[transaction.address];
  return std::max(entry.free_at, line_.ready_at(entry.device->timing.gap));
}

// Whether a question of the gateway's own is needed is known only when its turn has come. It is
// never the last transaction of a job.
void Bus::skip_known_settings(Job& job) {
  while (job.transaction().must_hold != nullptr &&
         devices_[job.transaction().address].setting_known) {
    ++job.current;
    job.tries = 0;
  }
}

void Bus::transmit(Job& job, Instant now) {
  skip_known_settings(job);
  Transaction& transaction = job.transaction();
  DeviceEntry& entry = devices_[transaction.address];
  drive::DeviceTiming timing = settings_.timing;
  if (transaction.is_broadcast()) {
    ++counters_.broadcasts;
  } else {
    ++entry.counters.transmissions;
    timing = entry.device->timing_of(transaction.request);
    transaction.boot_time = entry.device->silent_after(transaction.request);
  }
  devices_.note_reconfiguring(transaction);
  ++counters_.transmissions;
  counters_.retries += job.tries > 0 ? 1U : 0U;
  ++job.tries;
  job.was_on_wire = job.was_on_wire || transaction.must_hold == nullptr;
  job.in_flight = true;
  actions_.emplace_back(TransmitFrame{line_.begin(transaction, timing, now)});
}

}  // namespace mbgate::bus
