// SPDX-License-Identifier: Apache-2.0
// A transaction goes on the wire: what must hold by then, and what is noted of it.
#include <algorithm>
#include <utility>

#include "base/assert.hpp"
#include "bus/transmission/dispatch.hpp"

namespace mbgate::bus {
namespace {

// Identical reads that wait at the same time are transmitted once (`coalesce`). A read is not
// shared across a write to the device that waits between, nor ahead of earlier requests of its own
// client. So no client gets data older than its request or its own write. On a Modbus TCP bus one
// device may be asked by several units; should these be drives after all, each answers for itself.
// The transmission, whose turn it is, gets the reads that it can answer as its followers, and the
// queue loses them.
void gather_followers(BusQueue& queue, Job& leader) {
  if (!leader.is_single_read()) {
    return;
  }
  boost::container::small_vector<Job*, 8> joined;  // the queue does not change while it is visited
  const auto writes = queue.writes_around(leader.address(), leader.sequence);
  queue.visit_fronts(leader.address(), [&](Job& job) {
    const bool joins = job.is_single_read() && job.sequence > writes.first &&
                       job.sequence < writes.second &&
                       job.transaction().is_like(leader.transaction());
    if (joins) {
      joined.push_back(&job);
    }
    return joins;
  });
  for (Job* job : joined) {
    queue.remove(*job);
    leader.sent.followers.push_back(job);
  }
}

}  // namespace

// What src/README.md says of each transmission.
void Dispatch::check_allowed(const Job& job, Instant now) const {
  const bool is_stop = job.is_stop();
  MBGATE_ASSERT(parts_.transmissions.may_go_on(job),
                "a job has one transmission on the wire, and goes beside no stop to its device");
  MBGATE_ASSERT(parts_.transmissions.has_room() || (is_stop && !parts_.quarantines()),
                "no more is on the wire than there is room for");
  MBGATE_ASSERT(is_stop || !job.abandoned, "nothing is transmitted for a client that has gone");
  MBGATE_ASSERT(is_stop || !job.overtaken, "no write is transmitted behind its stop");
  MBGATE_ASSERT(is_stop || now < job.ends_at(job),
                "nothing is begun, nor repeated, after its deadline");
  MBGATE_ASSERT(is_stop || ready_at(parts_, job).at <= now,
                "nothing is transmitted before its silence, nor to a device that owes an answer");
  MBGATE_ASSERT(is_stop || job.sent.tries == 0 || job.transaction().request.is_read() ||
                    parts_.devices[job.transaction().address].in_force().retry_writes,
                "a write is transmitted once");
}

void Dispatch::transmit(Job& job, Instant now) {
  if (const std::size_t next = next_transaction(parts_, job); next != job.current) {
    job.current = next;  // known settings are not asked for again
    job.sent.tries = 0;
  }
  check_allowed(job, now);
  if (job.sent.tries == 0) {
    const DeviceEntry& entry = parts_.devices[job.address()];
    job.sent.first_at = now;
    job.sent.writes_before = entry.cache.writes_ended();
    if (parts_.settings.coalesce) {
      gather_followers(parts_.queue, job);
    }
  }
  const drive::DeviceTiming timing = note_transmission(job, now);
  Transaction& sent = job.transaction();
  OwedAnswers owed;
  if (parts_.quarantines()) {
    const DeviceEntry& entry = parts_.devices[sent.address];
    // An earlier stop of the same bytes, without another write since, has stopped the drive too.
    // What a line brings of one that was sent before it was opened may be its echo.
    const bool is_stop = job.is_stop();
    owed = entry.hold.owed(sent.request, sent.unit,
                           is_stop ? parts_.link.opened_at() : job.sent.first_at, now,
                           entry.in_force());
    std::ranges::for_each(owed, [&](OwedAnswer& it) { it.is_stop = is_stop; });
  }
  const auto quiet_since = [silence = parts_.line.silence()] {
    return silence == nullptr ? std::nullopt : std::optional(silence->quiet_since());
  };
  const auto silent_since = quiet_since();
  diagnosis_.note_begins(now);
  TransmitFrame frame{parts_.line.begin(sent, timing, std::move(owed), now)};
  if (!sent.is_broadcast()) {
    // Should the line be lost before its end, it may have been carried out.
    parts_.devices[sent.address].hold_after(sent.request, parts_.line.possible_at());
  }
  if (parts_.is_traced) {
    parts_.actions.push(TransmissionBegan{title_of(job), sent.address, sent.is_broadcast(),
                                          job.sent.tries, silent_since, quiet_since()});
  }
  parts_.actions.push(std::move(frame));
}

// True: its answer tells whether the device owes anything.
bool Dispatch::note_asked(const Job& job, Instant now) {
  const Transaction& sent = job.transaction();
  DeviceEntry& entry = parts_.devices[sent.address];
  const bool is_silent = sent.may_stay_silent();
  const bool is_decisive =
      entry.hold.note_asked(is_silent ? nullptr : &sent.request, now, entry.in_force(),
                            job.is_stop() && entry.health.is_offline());
  entry.asked_at = now;
  if (!sent.request.is_read()) {
    entry.hold.note_written(sent.request, job.is_stop());
  }
  if (!is_silent) {
    parts_.adapter.note_request();
  }
  return is_decisive && parts_.quarantines();
}

// Where anything but a stop is done to a device, the next stop is urgent again. What its owner
// calls a stop may be none.
void Dispatch::note_changing(const Transaction& sent) {
  if (sent.request.is_read()) {
    return;
  }
  const bool stops = parts_.devices.is_stop(sent.address, sent.request, sent.broadcast);
  if (sent.is_broadcast()) {  // to others than those that it stops it may be an ordinary write
    stops ? parts_.acknowledged.forget_single() : parts_.acknowledged.forget_all();
  } else if (!stops) {
    parts_.acknowledged.forget(sent.address);
  }
}

// Keeps the books of it; returns the times that hold for it.
drive::DeviceTiming Dispatch::note_transmission(Job& job, Instant now) {
  Transaction& sent = job.transaction();
  BusCounters& counters = parts_.counters;
  DeviceEntry& entry = parts_.devices[sent.address];
  drive::DeviceTiming timing = parts_.settings.timing;
  if (job.is_stop() && job.sent.tries == 0) {
    job.sent.is_one_try = is_given_up(parts_, job);
  }
  if (sent.is_broadcast()) {
    ++counters.broadcasts;
    parts_.devices.note_written(sent);
  } else {
    ++entry.counters.transmissions;
    const bool is_decisive = note_asked(job, now);
    const bool is_offline = entry.health.is_offline();
    job.sent.is_probe = !job.is_stop() && (is_offline || is_decisive);
    // A write as the probe does not: a device that is back may carry it out, and then answers.
    const bool hurries = job.sent.is_one_try || (job.sent.is_probe && sent.request.is_read());
    timing = entry.in_force(sent.request, hurries);
    const Duration usual = entry.in_force(sent.request, false).response_timeout;
    job.sent.hurried_by = std::max(usual - timing.response_timeout, Duration{0});
    sent.boot_time = entry.device->silent_after(sent.request);
    counters.probes += job.sent.is_probe ? 1U : 0U;
  }
  parts_.devices.note_reconfiguring(sent);
  note_changing(sent);
  parts_.last_sent.note(job.job_class, sent.address);
  ++counters.transmissions;
  counters.stops += job.is_stop() ? 1U : 0U;
  counters.retries += job.sent.tries > 0 ? 1U : 0U;
  ++job.sent.tries;
  job.sent.last_at = now;
  job.sent.in_flight = true;
  job.was_on_wire = job.was_on_wire || sent.must_hold == nullptr;
  for (Job* follower : job.sent.followers) {
    follower->was_on_wire = true;
  }
  return timing;
}

}  // namespace mbgate::bus
