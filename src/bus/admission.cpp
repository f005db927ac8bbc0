// SPDX-License-Identifier: Apache-2.0
// What becomes of a request before it waits: it is refused, answered at once, or queued.
#include <algorithm>
#include <span>
#include <utility>

#include "base/assert.hpp"
#include "bus/bus.hpp"
#include "bus/queue/scheduler.hpp"

namespace mbgate::bus {
namespace {

/// Has one of its transmissions, or forms, ended? Questions of the gateway's own are none.
bool is_begun(const Job& stop) {
  return std::ranges::any_of(std::span(stop.transactions).first(stop.current),
                             [](const Transaction& ended) { return ended.must_hold == nullptr; });
}

bool are_same(const Job& one, const Job& other) {
  return std::ranges::equal(one.transactions, other.transactions, &Transaction::is_like);
}

// The forms of a broadcast are one command: it is a stop if any device takes it for one.
bool is_stop(const Parts& parts, const Job& job) {
  const auto is_part = [&](const Transaction& transaction) {
    return parts.devices.is_stop(transaction.address, transaction.request, transaction.broadcast);
  };
  return job.is_broadcast() ? std::ranges::any_of(job.transactions, is_part)
                            : std::ranges::all_of(job.transactions, is_part);
}

bool take_cached(Parts& parts, Job& job, Instant now) {
  const DeviceEntry& entry = parts.devices[job.address()];
  if (entry.device->cache == Duration{0} || !job.is_single_read()) {
    return false;
  }
  const modbus::Pdu* known = entry.cache.find(job.transaction(), now - entry.device->cache);
  if (known == nullptr) {
    return false;
  }
  job.transaction().response = *known;
  job.current = job.transactions.size();
  ++parts.counters.cached_reads;
  return true;
}

std::optional<Ending> end_at_once(Parts& parts, Job& job, Instant now) {
  const bool is_stop = job.is_stop();
  if (parts.stopping && !is_stop) {
    return Ending::cancelled;
  }
  if (parts.link.is_closed() && (!is_stop || parts.stopping)) {
    return Ending::closed;
  }
  if (is_stop || job.is_broadcast()) {
    return std::nullopt;
  }
  DeviceEntry& entry = parts.devices[job.address()];
  if (entry.health.is_offline() &&
      (now < held_until(parts, job) || !parts.probes.may_ask(job, now))) {
    entry.wanted_at = now;
    ++parts.counters.refused_offline;
    return Ending::offline;
  }
  return take_cached(parts, job, now) ? std::optional(Ending::answered) : std::nullopt;
}

// A full queue loses the newest read of the client address that has the most waiting.
bool push(Parts& parts, JobEnds& ends, Job& job) {
  while (!parts.queue.push(job)) {
    Job* evicted = parts.queue.read_to_evict();
    if (evicted == nullptr) {
      return false;
    }
    parts.queue.remove(*evicted);
    ++parts.counters.evicted;
    ends.end(*evicted, Ending::cancelled);
  }
  return true;
}

// Identical stops that wait are sent once.
bool push_stop(Parts& parts, Job& job) {
  Job* same =
      parts.stops.find_any([&](const Job& stop) { return !is_begun(stop) && are_same(stop, job); });
  if (same != nullptr) {
    auto& joined = same->sent.followers;
    const bool has_room = std::cmp_less(
        std::ranges::count(joined, job.source, [](const Job* it) { return it->source; }),
        kRoomForStops);
    if (has_room) {
      joined.push_back(&job);
    }
    return has_room;
  }
  if (!parts.stops.has_room(job)) {
    return false;
  }
  job.sent.waits_since = job.accepted_at;
  parts.stops.push(job);
  return true;
}

}  // namespace

bool Bus::submit(Job& job, Instant now) {
  MBGATE_ASSERT(!job.is_waiting() && !job.accepted, "a job is submitted once");
  if (job.job_class != JobClass::stop) {  // else its owner knows better
    job.job_class = is_stop(parts_, job) ? JobClass::stop
                    : job.is_read()      ? JobClass::read
                                         : JobClass::write;
  }
  if (const auto ending = end_at_once(parts_, job, now)) {
    ends_.end(job, *ending);
    return true;
  }
  job.sequence = ++sequence_;
  job.accepted_at = now;
  if (job.is_stop()) {
    ends_.overtake_writes(job);
  }
  const bool is_accepted = job.is_stop() ? push_stop(parts_, job) : push(parts_, ends_, job);
  if (!is_accepted) {
    ++parts_.counters.refused_full;
  } else {
    job.accepted = true;
    if (job.job_class != JobClass::read) {
      parts_.devices.note_write(job, &ReadCache::begin_write);
    }
    parts_.probes.note_accepted(job);
  }
  dispatch_.pump(now);
  return is_accepted;
}

}  // namespace mbgate::bus
