// SPDX-License-Identifier: Apache-2.0
#include "bus/transmission/job_ends.hpp"

#include <algorithm>
#include <utility>

#include "bus/queue/scheduler.hpp"

namespace mbgate::bus {
namespace {

// Does the stop cancel the write, which was accepted before it?
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
    return stopped && (write.is_broadcast() || std::ranges::any_of(write.transactions, reaches));
  };
  return std::ranges::any_of(parts.devices.devices(), stops_device);
}

}  // namespace

void JobEnds::end(Job& job, Ending ending) {
  release(job);
  parts_.actions.push(JobEnded{&job, ending});
}

void JobEnds::release(Job& job) {
  if (!std::exchange(job.accepted, false)) {
    return;
  }
  if (job.job_class != JobClass::read) {
    parts_.devices.note_write(job, &ReadCache::end_write);
  }
  parts_.probes.note_released(job, parts_.pumped_at);
}

void JobEnds::finish(Job& job, Ending ending) {
  for (Job* follower : job.sent.followers) {
    if (job.is_stop()) {
      follower->transactions = job.transactions;
      follower->current = job.current;
    }
    end(*follower, ending);
  }
  job.sent.followers.clear();
  parts_.transmissions.end(job);
  end(job, ending);
}

void JobEnds::advance(Job& job, Ending ending) {
  job.sent.tries = 0;
  if (++job.current == job.transactions.size()) {
    finish(job, ending);
  }
}

void JobEnds::expire(Instant now) {
  for (Job* job = parts_.queue.first_to_expire(); job != nullptr && now >= job->deadline;
       job = parts_.queue.first_to_expire()) {
    parts_.queue.remove(*job);
    ++parts_.counters.expired;
    end(*job, Ending::expired);
  }
}

// How a job ends of which nothing more is to be transmitted.
std::optional<Ending> JobEnds::over(const Job& job, const Job& running, Instant now) const {
  if (job.is_stop()) {
    return std::nullopt;
  }
  if (job.abandoned || job.overtaken || parts_.stopping) {
    return Ending::cancelled;
  }
  if (!job.is_broadcast() && parts_.devices[job.address()].health.is_offline()) {
    return Ending::offline;
  }
  // The device may owe an answer for long: a command must not be completed so late.
  const bool is_held =
      is_write(job.job_class) && now >= job.deadline && is_held_back(parts_, running, now);
  return is_held || now >= running.ends_at(job) ? std::optional(Ending::expired) : std::nullopt;
}

void JobEnds::drop_followers(Job& job, Instant now) {
  auto& followers = job.sent.followers;
  const auto dropped = std::ranges::remove_if(followers, [&](Job* follower) {
    const auto ending = over(*follower, job, now);
    if (ending) {
      parts_.counters.expired += *ending == Ending::expired ? 1U : 0U;
      end(*follower, *ending);
    }
    return ending.has_value();
  });
  followers.erase(dropped.begin(), dropped.end());
}

void JobEnds::end_over(Instant now) {
  Transmissions& transmissions = parts_.transmissions;
  for (std::size_t at = 0; at < transmissions.running().size();) {
    Job& leader = *transmissions.running()[at];
    if (leader.sent.in_flight) {
      ++at;
      continue;
    }
    drop_followers(leader, now);
    const auto ending = over(leader, leader, now);
    if (!ending) {
      ++at;
      continue;
    }
    parts_.counters.expired += *ending == Ending::expired ? 1U : 0U;
    if (leader.sent.followers.empty()) {
      finish(leader, *ending);
    } else {
      transmissions.hand_over(leader);  // others still want what the leader asked for
      end(leader, *ending);
    }
  }
}

void JobEnds::end_running(Ending ending) {
  while (!parts_.transmissions.running().empty()) {
    finish(*parts_.transmissions.running().front(), ending);
  }
}

void JobEnds::end_waiting(Ending ending) {
  while (Job* job = parts_.queue.first_to_expire()) {
    parts_.queue.remove(*job);
    end(*job, ending);
  }
}

void JobEnds::end_stops(Ending ending) {
  parts_.stops.wake(Instant::max());
  while (Job* stop = parts_.stops.find([](const Job& /*any*/) { return true; })) {
    parts_.stops.remove(*stop);
    finish(*stop, ending);
  }
}

// Ends those that wait and for which `is_one` says yes, and counts them.
template <typename Predicate>
void JobEnds::end_queued(Predicate is_one, Ending ending, std::uint64_t& count) {
  std::vector<Job*> found;
  parts_.queue.visit_all([&](Job& job) {
    if (is_one(job)) {
      found.push_back(&job);
    }
  });
  count += found.size();
  for (Job* job : found) {
    parts_.queue.remove(*job);
    end(*job, ending);
  }
}

void JobEnds::end_waiting_for(std::uint8_t address) {
  end_queued([&](const Job& job) { return !job.is_broadcast() && job.address() == address; },
             Ending::offline, parts_.counters.refused_offline);
}

void JobEnds::end_repeats() {
  const auto running = parts_.transmissions.running();
  for (Job* job : std::vector(running.begin(), running.end())) {
    const bool repeats_write = is_write(job->job_class) && !job->sent.in_flight &&
                               job->sent.tries > 0 && !job->transaction().request.is_read();
    if (repeats_write && !parts_.devices[job->transaction().address].in_force().retry_writes) {
      finish(*job, Ending::no_answer);
    }
  }
}

void JobEnds::overtake_writes(const Job& stop) {
  const auto is_overtaken = [&](const Job& job) { return is_stopped_by(parts_, stop, job); };
  end_queued(is_overtaken, Ending::cancelled, parts_.counters.overtaken_writes);
  for (Job* running : parts_.transmissions.running()) {
    running->overtaken = running->overtaken || is_overtaken(*running);
  }
}

}  // namespace mbgate::bus
