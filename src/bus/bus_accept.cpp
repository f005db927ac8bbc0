// SPDX-License-Identifier: Apache-2.0
// What becomes of a request before it waits: refused, answered at once, or given a place.
#include <algorithm>
#include <span>

#include "base/assert.hpp"
#include "bus/bus.hpp"

namespace mbgate::bus {
namespace {

/// Has one of its transmissions, or forms, ended? Questions of the gateway's own are none.
bool is_begun(const Job& stop) {
  return std::ranges::any_of(std::span(stop.transactions).first(stop.current),
                             [](const Transaction& ended) { return ended.must_hold == nullptr; });
}

}  // namespace

bool Bus::submit(Job& job, Instant now) {
  MBGATE_ASSERT(!job.is_waiting() && !job.accepted, "a job is submitted once");
  classify(job);
  if (const auto ending = end_at_once(job, now)) {
    end_job(job, *ending);
    return true;
  }
  job.sequence = ++sequence_;
  job.waits_since = now;
  if (job.job_class == JobClass::stop) {
    overtake_writes(job);
  }
  if (!push(job)) {
    ++counters_.refused_full;
    pump(now);
    return false;
  }
  note_accepted(job, now);
  pump(now);
  return true;
}

void Bus::note_accepted(Job& job, Instant now) {
  job.accepted = true;
  if (job.job_class != JobClass::read) {
    devices_.begin_write(job);
  }
  if (!probes_.note_accepted(job, now)) {
    refuse_free_probes(now);
  }
}

void Bus::classify(Job& job) const {
  const auto is_part_of_stop = [&](const Transaction& transaction) {
    return devices_.is_stop(transaction.address, transaction.request, transaction.broadcast);
  };
  if (job.job_class == JobClass::stop) {
    return;  // its owner knows better
  }
  // The forms of a broadcast are one command: it is a stop if any device takes it for one.
  const bool stops = job.is_broadcast() ? std::ranges::any_of(job.transactions, is_part_of_stop)
                                        : std::ranges::all_of(job.transactions, is_part_of_stop);
  if (stops) {
    job.job_class = JobClass::stop;
  } else {
    job.job_class = job.is_read() ? JobClass::read : JobClass::write;
  }
}

std::optional<Ending> Bus::end_at_once(Job& job, Instant now) {
  const bool is_stop = job.job_class == JobClass::stop;
  if (stopping_ && (!is_stop || link_.is_closed())) {
    return Ending::cancelled;
  }
  if (link_.is_closed()) {
    return Ending::closed;
  }
  if (is_stop || job.is_broadcast()) {
    return std::nullopt;
  }
  DeviceEntry& entry = devices_[job.address()];
  if (entry.health.is_offline() && (now < held_until(job) || !probes_.may_ask(job, now))) {
    entry.health.set_wanted_at(now);
    ++counters_.refused_offline;
    return Ending::offline;
  }
  return take_cached(job, now) ? std::optional(Ending::answered) : std::nullopt;
}

bool Bus::take_cached(Job& job, Instant now) {
  const DeviceEntry& entry = devices_[job.address()];
  if (entry.device->cache == Duration{0} || !job.is_single_read()) {
    return false;
  }
  const modbus::Pdu* known = entry.cache.find(job.transaction().request, now - entry.device->cache);
  if (known == nullptr) {
    return false;
  }
  job.transaction().response = *known;
  job.current = job.transactions.size();
  ++counters_.cached_reads;
  return true;
}

// Somebody else asks now: what waits for offline devices must not be in the way.
void Bus::refuse_free_probes(Instant now) {
  if (!probes_.any_free()) {
    return;
  }
  std::vector<Job*> refused;
  queue_.visit_all([&](Job& job) {
    if (job.probes_freely && devices_[job.address()].health.is_offline()) {
      refused.push_back(&job);
    }
  });
  counters_.refused_offline += refused.size();
  for (Job* job : refused) {
    devices_[job->address()].health.set_wanted_at(now);
    queue_.remove(*job);
    end_job(*job, Ending::offline);
  }
}

// Identical stops that wait are sent once. A full queue loses the newest read of the client address
// that has the most waiting.
bool Bus::push(Job& job) {
  if (job.job_class == JobClass::stop) {
    Job* same = queue_.find_stop([&](const Job& stop) {
      if (is_begun(stop)) {
        return false;
      }
      // A write between them that is let go first is to be stopped too.
      const bool crosses = !job.is_broadcast() &&
                           queue_.write_waits_between(job.address(), stop.sequence, job.sequence);
      return !crosses && std::ranges::equal(stop.transactions, job.transactions,
                                            [](const Transaction& a, const Transaction& b) {
                                              return a.address == b.address &&
                                                     a.broadcast == b.broadcast &&
                                                     a.request.pdu() == b.request.pdu();
                                            });
    });
    if (same == nullptr) {
      return queue_.push(job);
    }
    if (same->followers.size() >= kRoomForStops) {
      return false;
    }
    same->followers.push_back(&job);
    return true;
  }
  while (!queue_.push(job)) {
    Job* evicted = queue_.read_to_evict();
    if (evicted == nullptr) {
      return false;
    }
    queue_.remove(*evicted);
    ++counters_.evicted;
    end_job(*evicted, Ending::cancelled);
  }
  return true;
}

}  // namespace mbgate::bus
