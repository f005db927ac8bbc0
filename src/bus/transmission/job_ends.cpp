// SPDX-License-Identifier: Apache-2.0
#include "bus/transmission/job_ends.hpp"

#include <algorithm>
#include <utility>

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

void JobEnds::finish(Transmission& transmission, Ending ending) {
  Job& leader = *transmission.leader;
  for (Job* follower : transmission.followers) {
    if (transmission.is_stop()) {
      follower->transactions = leader.transactions;
      follower->current = leader.current;
    }
    end(*follower, ending);
  }
  transmission.followers.clear();
  parts_.transmissions.end(transmission);
  end(leader, ending);
}

void JobEnds::advance(Transmission& transmission, Ending ending) {
  transmission.tries = 0;
  if (++transmission.leader->current == transmission.leader->transactions.size()) {
    finish(transmission, ending);
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
std::optional<Ending> JobEnds::over(const Job& job, const Transmission& running,
                                    Instant now) const {
  if (job.job_class == JobClass::stop) {
    return std::nullopt;
  }
  if (job.abandoned || job.overtaken || parts_.stopping) {
    return Ending::cancelled;
  }
  if (!job.is_broadcast() && parts_.devices[job.address()].health.is_offline()) {
    return Ending::offline;
  }
  return now >= running.ends_at(job) ? std::optional(Ending::expired) : std::nullopt;
}

void JobEnds::drop_followers(Transmission& transmission, Instant now) {
  auto& followers = transmission.followers;
  const auto dropped = std::ranges::remove_if(followers, [&](Job* follower) {
    const auto ending = over(*follower, transmission, now);
    if (ending) {
      parts_.counters.expired += *ending == Ending::expired ? 1U : 0U;
      end(*follower, *ending);
    }
    return ending.has_value();
  });
  followers.erase(dropped.begin(), dropped.end());
}

void JobEnds::end_over(Instant now) {
  const auto& transmissions = parts_.transmissions;
  for (std::size_t at = 0; at < transmissions.running().size();) {
    Transmission& running = *transmissions.running()[at];
    if (running.in_flight) {
      ++at;
      continue;
    }
    drop_followers(running, now);
    Job& leader = *running.leader;
    const auto ending = over(leader, running, now);
    if (!ending) {
      ++at;
      continue;
    }
    parts_.counters.expired += *ending == Ending::expired ? 1U : 0U;
    if (running.followers.empty()) {
      finish(running, *ending);
    } else {
      Transmissions::hand_over(running);  // others still want what the leader asked for
      end(leader, *ending);
    }
  }
}

void JobEnds::end_running(Ending ending) {
  while (!parts_.transmissions.running().empty()) {
    finish(*parts_.transmissions.running().front(), ending);
  }
}

void JobEnds::end_waiting(Ending ending, Instant stops_since) {
  while (Job* job = parts_.queue.first_to_expire()) {
    parts_.queue.remove(*job);
    end(*job, ending);
  }
  const auto is_over = [&](const Transmission& it) { return it.waits_since <= stops_since; };
  if (parts_.stops.find_any(is_over) != nullptr) {
    parts_.stops.wake(Instant::max());
  }
  while (Transmission* stop = parts_.stops.find_any(is_over)) {
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
  for (Transmission* repeated : std::vector(running.begin(), running.end())) {
    const Job& job = *repeated->leader;
    const bool repeats_write = is_write(job.job_class) && !repeated->in_flight &&
                               repeated->tries > 0 && !job.transaction().request.is_read();
    if (repeats_write && !parts_.devices[job.transaction().address].in_force().retry_writes) {
      finish(*repeated, Ending::no_answer);
    }
  }
}

void JobEnds::overtake_writes(const Job& stop) {
  const auto is_overtaken = [&](const Job& job) { return is_stopped_by(parts_, stop, job); };
  end_queued(is_overtaken, Ending::cancelled, parts_.counters.overtaken_writes);
  for (const Transmission* running : parts_.transmissions.running()) {
    Job& job = *running->leader;
    job.overtaken = job.overtaken || is_overtaken(job);
  }
}

}  // namespace mbgate::bus
