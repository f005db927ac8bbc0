// SPDX-License-Identifier: Apache-2.0
// Jobs that share a transmission: who of them goes on, and what each gets of the response.
#include <algorithm>
#include <ranges>
#include <utility>

#include "bus/bus.hpp"
#include "bus/shared_read.hpp"

namespace mbgate::bus {

void Bus::share_response(Job& leader) {
  const modbus::Pdu response = *leader.on_wire().response;
  const auto whole = leader.merged ? leader.merged->request.reads() : std::nullopt;
  const auto give = [&](Job& job) {
    const auto& own = job.transaction().request.reads();
    job.transaction().response =
        whole && !response.is_exception() ? part_of(response, whole->range, own->range) : response;
    job.current = job.transactions.size() - 1;
  };
  give(leader);
  for (Job* follower : leader.followers) {
    give(*follower);
    follower->transmitted_at = leader.transmitted_at;
    follower->writes_before = leader.writes_before;
    remember(*follower);
    ++follower->current;
    ++counters_.shared_reads;
    counters_.merged_reads += leader.merged ? 1U : 0U;
  }
}

// What was read may answer the next one that asks, where the device allows it.
void Bus::remember(const Job& job) {
  const Transaction& transaction = job.transaction();
  DeviceEntry& entry = devices_[transaction.address];
  if (job.is_single_read() && entry.device->cache > Duration{0} &&
      ReadCache::can_hold(transaction.request) && !transaction.response->is_exception()) {
    entry.cache.put(transaction.request, *transaction.response, job.transmitted_at,
                    job.writes_before);
  }
}

// A merged read failed: its parts are sent one by one, before what their clients asked for later.
// Who asked for all of it himself has had his tries.
void Bus::split_up(Job& leader, Ending how) {
  std::erase(running_, &leader);
  const auto whole = std::exchange(leader.merged, nullptr);
  auto parts = std::exchange(leader.followers, {});
  parts.insert(parts.begin(), &leader);
  for (Job* part : parts | std::views::reverse) {
    part->unmerged = true;
    part->tries = 0;
    if (part->transaction().request.pdu() == whole->request.pdu()) {
      part->transaction().response = whole->response;
      end_job(*part, how);
    } else if (part->abandoned || stopping_) {
      end_job(*part, Ending::cancelled);
    } else {
      queue_.push_front(*part);
    }
  }
}

// How a job ends of which nothing more is to be transmitted.
std::optional<Ending> Bus::over(const Job& job, Instant now) const {
  if (job.job_class == JobClass::stop) {
    return std::nullopt;
  }
  if (job.abandoned || job.overtaken || stopping_) {
    return Ending::cancelled;
  }
  if (!job.is_broadcast() && devices_[job.address()].health.is_offline()) {
    return Ending::offline;
  }
  return now >= job.deadline ? std::optional(Ending::expired) : std::nullopt;
}

void Bus::drop_followers(Job& leader, Instant now) {
  const auto dropped = std::ranges::remove_if(leader.followers, [&](Job* follower) {
    const auto ending = over(*follower, now);
    if (ending) {
      counters_.expired += *ending == Ending::expired ? 1U : 0U;
      end_job(*follower, *ending);
    }
    return ending.has_value();
  });
  leader.followers.erase(dropped.begin(), dropped.end());
}

void Bus::end_over(Instant now) {
  for (std::size_t at = 0; at < running_.size();) {
    Job& job = *running_[at];
    if (job.in_flight) {
      ++at;
      continue;
    }
    drop_followers(job, now);
    const auto ending = over(job, now);
    if (!ending) {
      ++at;
      continue;
    }
    counters_.expired += *ending == Ending::expired ? 1U : 0U;
    if (job.followers.empty()) {
      finish(job, *ending);
    } else {
      hand_over(job, *ending);
    }
  }
}

// Of what is neither in the queue nor on the wire, whatever keeps it waiting.
void Bus::watch_deadlines() {
  for (const Job* job : running_) {
    if (job->in_flight || job->job_class == JobClass::stop) {
      continue;
    }
    next_start_ = earlier(next_start_, Wake{job->deadline});
    for (const Job* follower : job->followers) {
      next_start_ = earlier(next_start_, Wake{follower->deadline});
    }
  }
}

// The leader ends, but others still want what it asked for.
void Bus::hand_over(Job& leader, Ending ending) {
  Job& heir = *leader.followers.front();
  heir.followers.assign(leader.followers.begin() + 1, leader.followers.end());
  leader.followers.clear();
  heir.merged = std::move(leader.merged);
  heir.tries = leader.tries;
  heir.cut = leader.cut;
  heir.transmitted_at = leader.transmitted_at;
  heir.last_sent = leader.last_sent;
  heir.turn = leader.turn;
  heir.writes_before = leader.writes_before;
  std::ranges::replace(running_, &leader, &heir);
  end_job(leader, ending);
}

}  // namespace mbgate::bus
