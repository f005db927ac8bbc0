// SPDX-License-Identifier: Apache-2.0
// A transaction goes on the wire: what must hold by then, and what is noted of it.
#include "base/assert.hpp"
#include "bus/bus.hpp"
#include "bus/shared_read.hpp"

namespace mbgate::bus {

// Whether a question of the gateway's own is needed is known only when its turn has come. It is
// never the last transaction of a job. A stop asks nothing.
std::size_t Bus::next_transaction(const Job& job) const {
  std::size_t next = job.current;
  while (
      job.transactions[next].must_hold != nullptr &&
      (job.job_class == JobClass::stop || devices_[job.transactions[next].address].setting_known)) {
    ++next;
  }
  return next;
}

void Bus::skip_known_settings(Job& job) {
  if (const std::size_t next = next_transaction(job); next != job.current) {
    job.current = next;
    job.tries = 0;
  }
}

// What src/README.md says of each transmission.
void Bus::check_allowed(const Job& job, Instant now) const {
  const bool is_stop = job.job_class == JobClass::stop;
  MBGATE_ASSERT(!job.in_flight, "a job has one transmission on the wire");
  MBGATE_ASSERT(is_stop || !job.abandoned, "nothing is transmitted for a client that has gone");
  MBGATE_ASSERT(is_stop || !job.overtaken, "no write is transmitted behind its stop");
  MBGATE_ASSERT(is_stop || now < job.deadline, "nothing is transmitted after its deadline");
  MBGATE_ASSERT(is_stop || ready_at(job) <= now,
                "nothing is transmitted before its silence, nor to a device that owes an answer");
  MBGATE_ASSERT(is_stop || job.tries == 0 || job.transaction().request.is_read() ||
                    devices_[job.transaction().address].timing().retry_writes,
                "a write is transmitted once");
}

void Bus::transmit(Job& job, Instant now) {
  skip_known_settings(job);
  check_allowed(job, now);
  const auto cuts = [this](const Job& it) { return !waits_patiently(it); };
  Job* stop = job.job_class == JobClass::stop ? nullptr : queue_.find_stop(cuts);
  if (stop != nullptr) {
    stop->held_by_writes += held_by(*stop, ready_at(job));
  }
  if (job.tries == 0) {
    job.transmitted_at = now;
    job.writes_before = devices_[job.address()].cache.writes_ended();
    gather_followers(
        queue_, job, *devices_[job.address()].device,
        {settings_.coalesce, settings_.merge && !devices_[job.address()].merge_refused});
  }
  Transaction& transaction = job.on_wire();
  const drive::DeviceTiming timing = note_transmission(job, transaction, now);
  OwedAnswers owed;
  if (quarantines_) {
    // By the device's own times: that a probe waits for less makes no quarantine shorter.
    const DeviceEntry& entry = devices_[transaction.address];
    owed.count = entry.health.owed(transaction.request.function(), now, entry.timing());
    owed.alike = entry.health.owed_alike(transaction.request, now, entry.timing());
  }
  actions_.push(TransmitFrame{line_.begin(transaction, timing, owed, now)});
  if (stop != nullptr && in_the_way_of(*stop) == &job) {
    line_.limit_wait(transaction, stop->waits_since + settings_.stop_wait, settings_.stop_wait);
  }
}

void Bus::note_turn(Job& job, DeviceEntry& entry) {
  const std::uint8_t address = job.transaction().address;
  turn_of_others_ = last_address_ == address ? turn_of_others_ : turn_;
  last_address_ = address;
  job.turn = ++turn_;
  if (job.job_class != JobClass::stop) {
    entry.last_turn = other_turn_ = turn_;
  } else if (job.tries == 0) {
    job.is_one_try = waits_patiently(job);
  }
}

// Keeps the books of it; returns the times that hold for it.
drive::DeviceTiming Bus::note_transmission(Job& job, Transaction& transaction, Instant now) {
  DeviceEntry& entry = devices_[transaction.address];
  drive::DeviceTiming timing = settings_.timing;
  if (transaction.is_broadcast()) {
    ++counters_.broadcasts;
  } else {
    ++entry.counters.transmissions;
    timing = entry.device->timing_of(transaction.request);
    transaction.boot_time = entry.device->silent_after(transaction.request);
    if (entry.health.is_offline()) {
      timing.response_timeout = timing.probe_timeout_or_default();
      job.is_probe = job.job_class != JobClass::stop;
      counters_.probes += job.is_probe ? 1U : 0U;
    }
    entry.health.note_asked(now, entry.timing());
    if (job.job_class == JobClass::write && !transaction.request.is_read()) {
      entry.health.note_written();
    }
    if (!transaction.may_stay_silent()) {
      adapter_.note_request();
    }
  }
  devices_.note_reconfiguring(transaction);
  note_turn(job, entry);
  ++counters_.transmissions;
  counters_.stops += job.job_class == JobClass::stop ? 1U : 0U;
  counters_.retries += job.tries > 0 ? 1U : 0U;
  writes_in_row_ = job.job_class == JobClass::read ? 0 : writes_in_row_ + 1;
  ++job.tries;
  job.last_sent = now;
  job.was_on_wire = job.was_on_wire || transaction.must_hold == nullptr;
  job.in_flight = true;
  for (Job* follower : job.followers) {
    follower->was_on_wire = true;
  }
  return timing;
}

}  // namespace mbgate::bus
