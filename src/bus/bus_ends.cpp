// SPDX-License-Identifier: Apache-2.0
// What becomes of a job when a transmission of it has ended.
#include <algorithm>
#include <utility>

#include "base/assert.hpp"
#include "bus/bus.hpp"

namespace mbgate::bus {
namespace {

bool holds_one_of(const std::vector<std::uint16_t>& wanted, const Transaction& transaction) {
  constexpr std::size_t kData = 2;  // after function and byte count (6.3)
  const modbus::Pdu& response = *transaction.response;
  return !response.is_exception() &&
         std::ranges::find(wanted, modbus::load_be16(response.bytes(), kData)) != wanted.end();
}

bool is_still_asked_for(const drive::Device& device, const std::vector<std::uint16_t>& wanted) {
  const auto* stated = device.stated_order();
  return stated != nullptr && *stated == wanted;
}

}  // namespace

void Bus::handle_end(const LineEnd& end, Instant now) {
  Job& job = **std::ranges::find_if(
      running_, [&](Job* running) { return &running->on_wire() == end.transaction; });
  job.in_flight = false;
  let_by_ = let_by_ == &job ? nullptr : let_by_;
  const std::uint8_t address = end.transaction->address;
  const bool wants_answer = !end.transaction->is_broadcast() && !end.transaction->may_stay_silent();
  const std::uint8_t function = end.transaction->request.function();
  DeviceEntry& entry = devices_[address];
  entry.counters.noise_bytes += end.noise;
  if (!std::exchange(own_heard_, false) && end.how == LineEnd::How::response &&
      end.transaction->request.is_read()) {
    note_denied_echo(false);
  }
  switch (end.how) {
    case LineEnd::How::response:
      handle_response(job, end, now);
      entry.answered_at = now;
      entry.answered_function = function;
      break;
    case LineEnd::How::sent:
      devices_.hold_booting(*end.transaction, now);
      advance(job, Ending::transmitted);
      break;
    case LineEnd::How::no_response: handle_silence(job, end, now); break;
    case LineEnd::How::damaged:
      ++counters_.bad_crcs;
      ++entry.counters.bad_crcs;
      entry.health.note_spoilt(end.transaction->request, end.due);
      entry.note_heard();
      probes_.note_unanswered(job, now);
      handle_failure(job, now);
      break;
  }
  if (wants_answer) {
    if (end.how != LineEnd::How::response || now < entry.health.held_until(entry.timing())) {
      entry.owed_until = std::max(entry.owed_until, end.due);
    }
    note_quality(end, address);
  }
  frame_heard_ = false;
}

// Fewer bytes than these are a driver that turns off.
constexpr std::size_t kLeastHeard = 3;

void Bus::note_quality(const LineEnd& end, std::uint8_t address) {
  AnswerQuality& quality = quality_[address];
  switch (end.how) {
    case LineEnd::How::response:
      quality.note_answered();
      quality_.note_answer(false);
      break;
    case LineEnd::How::damaged:
      quality.note_damaged();
      quality_.note_answer(true);
      break;
    case LineEnd::How::no_response:
      if (end.heard >= kLeastHeard && !frame_heard_) {
        quality.note_unreadable(end.heard_after, quality_.unasked());
      } else {
        quality.note_silent();
      }
      break;
    case LineEnd::How::sent: break;
  }
  tell_quality(address);
}

void Bus::tell_quality(std::uint8_t address) {
  while (const auto change = quality_.take_change(address)) {
    actions_.push(*change);
  }
}

void Bus::handle_response(Job& job, const LineEnd& end, Instant now) {
  const Transaction& asked = job.on_wire();
  MBGATE_ASSERT(is_fitting(modbus::check_response(asked.request, asked.response->bytes())),
                "a response fits the request on the wire");
  DeviceEntry& entry = devices_[asked.address];
  const bool exception = asked.response->is_exception();
  ++counters_.responses;
  ++entry.counters.responses;
  entry.note_heard();
  never_silent_reported_ = false;
  counters_.exceptions += exception ? 1U : 0U;
  entry.counters.exceptions += exception ? 1U : 0U;
  if (end.early) {
    ++counters_.early_responses;
    ++entry.counters.early_responses;
    if (!std::exchange(entry.early_reported, true)) {
      notify(DeviceNotice::Kind::early, asked.address);
    }
  }
  if (entry.health.note_answered(
          {asked.request, asked.response->bytes(), job.last_sent, end.due, end.took}, now)) {
    notify(DeviceNotice::Kind::back, asked.address);
  }
  job.is_probe = false;
  if (exception && job.merged) {
    entry.merge_refused = true;
    split_up(job, Ending::answered);
    return;
  }
  if (job.is_single_read()) {
    share_response(job);
  }
  const Transaction& transaction = job.transaction();
  if (transaction.must_hold != nullptr) {
    const bool holds = holds_one_of(*transaction.must_hold, transaction);
    // Other settings, which came meanwhile, may expect another one.
    entry.setting_known = holds && is_still_asked_for(*entry.device, *transaction.must_hold);
    if (!holds) {
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
    probes_.note_unanswered(job, now);
    if (transaction.boot_time) {
      entry.free_at = now + *transaction.boot_time;
    }
    advance(job, Ending::transmitted);
    return;
  }
  ++counters_.timeouts;
  ++entry.counters.timeouts;
  if (job.job_class == JobClass::stop) {
    entry.last_stop_turn = job.turn;
  }
  const bool lost =
      entry.health.note_unanswered(transaction.request, job.last_sent, end.due, entry.timing());
  probes_.note_unanswered(job, now);
  if (lost) {
    go_offline(entry, transaction.address, now);
  }
  handle_failure(job, now);
}

void Bus::handle_failure(Job& job, Instant now) {
  const DeviceEntry& entry = devices_[job.on_wire().address];
  if (job.job_class == JobClass::stop) {
    handle_stop_failure(job, now);
    return;
  }
  const bool may_repeat = (job.transaction().request.is_read() || entry.timing().retry_writes) &&
                          !entry.health.is_offline() && !job.is_probe;
  if (may_repeat && job.tries <= entry.timing().retries) {
    return;
  }
  if (job.merged && !entry.health.is_offline()) {
    split_up(job, Ending::no_answer);
  } else {
    finish(job, Ending::no_answer);
  }
}

void Bus::end_repeats() {
  const std::vector<Job*> running = running_;
  for (Job* job : running) {
    const bool repeats_write = job->job_class == JobClass::write && !job->in_flight &&
                               job->tries > 0 && !job->transaction().request.is_read();
    if (repeats_write && !devices_[job->transaction().address].timing().retry_writes) {
      finish(*job, Ending::no_answer);
    }
  }
}

void Bus::go_offline(DeviceEntry& entry, std::uint8_t address, Instant now) {
  entry.health.set_probe_at(now + entry.timing().probe_interval);
  entry.merge_refused = false;
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
