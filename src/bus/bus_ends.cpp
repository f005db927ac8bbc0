// SPDX-License-Identifier: Apache-2.0
// What becomes of a job when a transmission of it has ended.
#include <algorithm>

#include "bus/bus.hpp"

namespace mbgate::bus {
namespace {

constexpr int kPercent = 100;

bool holds_one_of(const std::vector<std::uint16_t>& wanted, const Transaction& transaction) {
  constexpr std::size_t kData = 2;  // after function and byte count (6.3)
  const modbus::Pdu& response = *transaction.response;
  return !response.is_exception() &&
         std::ranges::find(wanted, modbus::load_be16(response.bytes(), kData)) != wanted.end();
}

}  // namespace

void Bus::handle_end(const LineEnd& end, Instant now) {
  Job& job = **std::ranges::find_if(
      running_, [&](Job* running) { return &running->on_wire() == end.transaction; });
  job.in_flight = false;
  switch (end.how) {
    case LineEnd::How::response: handle_response(job, end, now); return;
    case LineEnd::How::sent:
      devices_.hold_booting(*end.transaction, now);
      advance(job, Ending::transmitted);
      return;
    case LineEnd::How::no_response: handle_silence(job, end, now); return;
    case LineEnd::How::damaged: {
      DeviceEntry& entry = devices_[end.transaction->address];
      ++counters_.bad_crcs;
      ++entry.counters.bad_crcs;
      entry.health.note_spoilt(end.due);
      note_probe(job, now);
      handle_failure(job, now);
      return;
    }
  }
}

void Bus::handle_response(Job& job, const LineEnd& end, Instant now) {
  const Transaction& asked = job.on_wire();
  DeviceEntry& entry = devices_[asked.address];
  const bool exception = asked.response->is_exception();
  ++counters_.responses;
  ++entry.counters.responses;
  counters_.exceptions += exception ? 1U : 0U;
  entry.counters.exceptions += exception ? 1U : 0U;
  if (end.early) {
    ++counters_.early_responses;
    ++entry.counters.early_responses;
    if (!std::exchange(entry.early_reported, true)) {
      notify(DeviceNotice::Kind::early, asked.address);
    }
  }
  if (entry.health.note_answered(end.due, now)) {
    notify(DeviceNotice::Kind::back, asked.address);
  }
  job.is_probe = false;
  if (exception && job.merged) {
    split_up(job);
    return;
  }
  if (job.is_single_read()) {
    share_response(job);
  }
  const Transaction& transaction = job.transaction();
  if (transaction.must_hold != nullptr) {
    entry.setting_known = holds_one_of(*transaction.must_hold, transaction);
    if (!entry.setting_known) {
      finish(job, Ending::mismatched);
      return;
    }
  }
  if (exception) {
    finish(job, Ending::answered);
    return;
  }
  if (transaction.boot_time) {
    entry.free_at = now + *transaction.boot_time;  // it boots, though it has answered before
  }
  remember(job);
  advance(job, Ending::answered);
}

void Bus::handle_silence(Job& job, const LineEnd& end, Instant now) {
  const Transaction& transaction = job.on_wire();
  DeviceEntry& entry = devices_[transaction.address];
  entry.setting_known = false;
  entry.cache.clear();
  if (transaction.may_stay_silent()) {
    note_probe(job, now);
    if (transaction.boot_time) {
      entry.free_at = now + *transaction.boot_time;
    }
    advance(job, Ending::transmitted);
    return;
  }
  ++counters_.timeouts;
  ++entry.counters.timeouts;
  const bool lost = entry.health.note_unanswered(end.due, entry.timing());
  note_probe(job, now);
  if (lost) {
    go_offline(entry, transaction.address, now);
  }
  handle_failure(job, now);
}

void Bus::handle_failure(Job& job, Instant now) {
  const DeviceEntry& entry = devices_[job.on_wire().address];
  if (job.job_class == JobClass::stop) {
    // What its owner sends as a stop, but is none, may not be harmless if it is done twice.
    const Transaction& sent = job.transaction();
    const bool may_repeat_stop = is_stop(sent.address, sent.request, sent.broadcast);
    if (may_repeat_stop && job.tries <= entry.timing().stop_retries) {
      repeat_stop(job, now);
      return;
    }
    ++counters_.stops_unanswered;
    notify(DeviceNotice::Kind::stop_unanswered, job.on_wire().address);
    finish(job, Ending::no_answer);
    return;
  }
  const bool may_repeat = (job.transaction().request.is_read() || entry.timing().retry_writes) &&
                          !entry.health.is_offline() && !job.is_probe;
  if (may_repeat && job.tries <= entry.timing().retries) {
    return;
  }
  if (job.merged && !entry.health.is_offline()) {
    split_up(job);
  } else {
    finish(job, Ending::no_answer);
  }
}

// A good frame came that answers nothing that is asked now.
void Bus::handle_stray(const Stray& stray, Instant now) {
  const std::uint8_t address = stray.address;
  DeviceEntry& entry = devices_[address];
  const auto late = stray.is_response ? entry.health.note_unexpected(now, entry.timing())
                                      : std::optional<DeviceHealth::Late>();
  if (!late) {
    const bool is_asked = std::ranges::any_of(
        running_, [&](const Job* job) { return job->in_flight && job->address() == address; });
    if (!is_asked && entry.health.owed(now, entry.timing()) == 0) {
      ++counters_.foreign_frames;
      if (!std::exchange(foreign_reported_, true)) {
        notify(DeviceNotice::Kind::foreign, address);
      }
    }
    return;
  }
  ++counters_.late_responses;
  ++entry.counters.late_responses;
  if (late->grew) {
    actions_.push(DeviceNotice{DeviceNotice::Kind::late, address, late->lateness,
                               entry.health.quarantine(now, entry.timing())});
  }
  if (late->back) {
    notify(DeviceNotice::Kind::back, address);
  }
}

// All probes of a bus together take no more than their share of its time.
void Bus::note_probe(Job& job, Instant now) {
  if (!job.is_probe) {
    return;
  }
  DeviceEntry& entry = devices_[job.on_wire().address];
  entry.health.set_probe_at(job.last_sent + entry.timing().probe_interval);
  next_probe_ = std::max(next_probe_, job.last_sent) +
                (now - job.last_sent) * kPercent / settings_.probe_share;
}

void Bus::go_offline(DeviceEntry& entry, std::uint8_t address, Instant now) {
  entry.health.set_probe_at(now + entry.timing().probe_interval);
  notify(DeviceNotice::Kind::lost, address);
  std::vector<Job*> waiting;
  queue_.visit_all([&](Job& job) {
    if (!job.is_broadcast() && job.address() == address) {
      waiting.push_back(&job);
    }
  });
  counters_.refused_offline += waiting.size();
  for (Job* job : waiting) {
    queue_.remove(*job);
    end_job(*job, Ending::offline);
  }
}

void Bus::advance(Job& job, Ending ending) {
  job.tries = 0;
  if (++job.current == job.transactions.size()) {
    finish(job, ending);
  }
}

void Bus::finish(Job& job, Ending ending) {
  std::erase(running_, &job);
  end_group(job, ending);
}

}  // namespace mbgate::bus
