// SPDX-License-Identifier: Apache-2.0
#include "bus/queue/admission.hpp"

#include <algorithm>
#include <span>

#include "base/assert.hpp"
#include "bus/queue/scheduler.hpp"

namespace mbgate::bus {
namespace {

/// Has one of its transmissions, or forms, ended? Questions of the gateway's own are none.
bool is_begun(const Job& stop) {
  return std::ranges::any_of(std::span(stop.transactions).first(stop.current),
                             [](const Transaction& ended) { return ended.must_hold == nullptr; });
}

bool are_same(const Job& one, const Job& other) {
  return std::ranges::equal(
      one.transactions, other.transactions, [](const Transaction& a, const Transaction& b) {
        return a.address == b.address && a.unit == b.unit && a.broadcast == b.broadcast &&
               a.request.pdu() == b.request.pdu();
      });
}

}  // namespace

Admitted Admission::admit(Job& job, Instant now) {
  MBGATE_ASSERT(!job.is_waiting() && !job.accepted, "a job is submitted once");
  classify(job);
  if (const auto ending = end_at_once(job, now)) {
    ends_.end(job, *ending);
    return Admitted::ended;
  }
  job.sequence = ++sequence_;
  job.accepted_at = now;
  if (job.job_class == JobClass::stop) {
    ends_.overtake_writes(job);
  }
  if (!(job.job_class == JobClass::stop ? push_stop(job) : push(job))) {
    ++parts_.counters.refused_full;
    return Admitted::refused;
  }
  job.accepted = true;
  if (job.job_class != JobClass::read) {
    parts_.devices.begin_write(job);
  }
  parts_.probes.note_accepted(job);
  return Admitted::waits;
}

void Admission::classify(Job& job) const {
  if (job.job_class == JobClass::stop) {
    return;  // its owner knows better
  }
  if (is_stop(job)) {
    job.job_class = JobClass::stop;
  } else {
    job.job_class = job.is_read() ? JobClass::read : JobClass::write;
  }
}

// The forms of a broadcast are one command: it is a stop if any device takes it for one.
bool Admission::is_stop(const Job& job) const {
  const auto is_part = [&](const Transaction& transaction) {
    return parts_.devices.is_stop(transaction.address, transaction.request, transaction.broadcast);
  };
  return job.is_broadcast() ? std::ranges::any_of(job.transactions, is_part)
                            : std::ranges::all_of(job.transactions, is_part);
}

std::optional<Ending> Admission::end_at_once(Job& job, Instant now) {
  const bool is_stop = job.job_class == JobClass::stop;
  if (parts_.stopping && !is_stop) {
    return Ending::cancelled;
  }
  if (parts_.link.is_closed() && (!is_stop || parts_.stopping)) {
    return Ending::closed;
  }
  if (is_stop || job.is_broadcast()) {
    return std::nullopt;
  }
  DeviceEntry& entry = parts_.devices[job.address()];
  if (entry.health.is_offline() &&
      (now < held_until(parts_, job) || !parts_.probes.may_ask(job, now))) {
    entry.health.set_wanted_at(now);
    ++parts_.counters.refused_offline;
    return Ending::offline;
  }
  return take_cached(job, now) ? std::optional(Ending::answered) : std::nullopt;
}

bool Admission::take_cached(Job& job, Instant now) {
  const DeviceEntry& entry = parts_.devices[job.address()];
  if (entry.device->cache == Duration{0} || !job.is_single_read()) {
    return false;
  }
  const modbus::Pdu* known = entry.cache.find(job.transaction().request, now - entry.device->cache);
  if (known == nullptr) {
    return false;
  }
  job.transaction().response = *known;
  job.current = job.transactions.size();
  ++parts_.counters.cached_reads;
  return true;
}

// A full queue loses the newest read of the client address that has the most waiting.
bool Admission::push(Job& job) {
  while (!parts_.queue.push(job)) {
    Job* evicted = parts_.queue.read_to_evict();
    if (evicted == nullptr) {
      return false;
    }
    parts_.queue.remove(*evicted);
    ++parts_.counters.evicted;
    ends_.end(*evicted, Ending::cancelled);
  }
  return true;
}

// Identical stops that wait are sent once.
bool Admission::push_stop(Job& job) {
  Transmission* same = parts_.stops.find_any([&](const Transmission& stop) {
    return !is_begun(*stop.leader) && are_same(*stop.leader, job);
  });
  if (same != nullptr) {
    const bool has_room = same->followers.size() < kRoomForStops;
    if (has_room) {
      same->followers.push_back(&job);
    }
    return has_room;
  }
  if (!parts_.stops.has_room(job.address())) {
    return false;
  }
  parts_.stops.push(parts_.transmissions.lead(job));
  return true;
}

}  // namespace mbgate::bus
