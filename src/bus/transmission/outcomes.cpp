// SPDX-License-Identifier: Apache-2.0
#include "bus/transmission/outcomes.hpp"

#include <algorithm>
#include <utility>

#include "base/assert.hpp"

namespace mbgate::bus {
namespace {

// What was read of one register; nothing if the device refuses to tell.
std::optional<std::uint16_t> register_of(const modbus::Pdu& response) {
  constexpr std::size_t kRegister = 2;  // after function and byte count (6.3)
  return response.is_exception() ? std::nullopt
                                 : std::optional(modbus::load_be16(response.bytes(), kRegister));
}

// Would the device be asked this today, and for the same setting?
bool is_still_asked(const drive::Device& device, const Transaction& question) {
  const auto* stated = device.stated_order();
  const auto& told = device.profile.word_order_register;
  const auto& read = question.request.reads();
  return stated != nullptr && *stated == *question.must_hold && told && read &&
         read->range.first == told->address;
}

Hold::Sent sent_of(const Job& it, const drive::Device& device, Instant due,
                   bool may_be_answered = false) {
  const modbus::Request& asked = it.transaction().request;
  const bool is_slow = device.timing_of(asked).response_timeout > device.timing.response_timeout;
  return {asked,           it.sent.last_at,  due,     it.sent.tries > 1,
          may_be_answered, it.sent.is_probe, is_slow, it.transaction().unit};
}

// For a stop: it is neither answered nor unanswered. Stops that cut each other short are.
bool is_cut(const Job& job, const LineEnd& end, Instant now) {
  return end.how == LineEnd::How::no_response && now + job.sent.hurried_by < end.due &&
         !job.is_stop();
}

LineEnd::How how_to_count(const Parts& parts, const Job& job, const LineEnd& end, Instant now) {
  const auto& response = job.transaction().response;
  if (end.how == LineEnd::How::response && parts.is_unreached(*response)) {
    return LineEnd::How::no_response;
  }
  return is_cut(job, end, now) ? LineEnd::How::sent : end.how;
}

}  // namespace

void Outcomes::handle_end(LineEnd end, Instant now) {
  Job& job = parts_.transmissions.find(end.transaction);
  end.due += job.sent.hurried_by;  // its answer may still come as late as any other
  job.sent.in_flight = false;
  parts_.last_sent.note_end(now);
  const Transaction& sent = *end.transaction;
  const Asked asked{
      sent.address,        sent.request.is_read(), !sent.is_broadcast() && !sent.may_stay_silent(),
      job.sent.tries == 1, job.sent.last_at,       how_to_count(parts_, job, end, now)};
  DeviceEntry& entry = parts_.devices[asked.address];
  entry.counters.noise_bytes += end.noise;
  if (parts_.is_traced) {
    TransmissionOver over{title_of(job), end.how, sent.may_stay_silent(),
                          end.how == LineEnd::How::response ? sent.response : std::nullopt};
    if (end.how == LineEnd::How::no_response && asked.wants_answer && parts_.quarantines()) {
      over.held_until = entry.hold.end_of_tail(end.due, entry.in_force());
    }
    parts_.actions.push(std::move(over));
  }
  switch (end.how) {
    case LineEnd::How::response: handle_response(job, end, now); break;
    case LineEnd::How::sent:
      parts_.devices.hold_booting(sent, now);
      note_stopped(job, now);
      ends_.advance(job, Ending::transmitted);
      break;
    case LineEnd::How::no_response: handle_silence(job, end, now); break;
    case LineEnd::How::misfit:
      // On a connection the frame is known, and so is the request that it answers.
      if (sent.response && !job.is_stop() &&
          entry.device->takes_limited(sent.request, sent.response->bytes())) {
        handle_response(job, end, now);
        break;
      }
      end.transaction->response.reset();
      [[fallthrough]];
    case LineEnd::How::damaged: handle_unreadable(job, end, now); break;
  }
  if (!sent.is_broadcast()) {
    entry.hold_after(sent.request, now);
  }
  const bool is_owed =
      end.how != LineEnd::How::response || now < entry.hold.until(entry.in_force());
  if (asked.wants_answer && is_owed) {
    entry.owed_until = std::max(entry.owed_until, end.due);
  }
  diagnosis_.note_ended(asked, end, now);
}

void Outcomes::take_response(Job& job, const LineEnd& end, Instant now) {
  const Transaction& asked = job.transaction();
  const modbus::Pdu& response = *asked.response;
  DeviceEntry& entry = parts_.devices[asked.address];
  MBGATE_ASSERT(is_fitting(modbus::check_response(asked.request, response.bytes())) ||
                    entry.device->takes_limited(asked.request, response.bytes()),
                "a response fits the request on the wire");
  ++parts_.counters.responses;
  ++entry.counters.responses;
  if (response.is_exception()) {
    ++parts_.counters.exceptions;
    ++entry.counters.exceptions;
    entry.counters.exceptions_by_code.note(response.bytes()[1]);
  }
  if (end.early) {
    ++parts_.counters.early_responses;
    ++entry.counters.early_responses;
    if (!std::exchange(entry.early_reported, true)) {
      diagnosis_.notify(DeviceNotice::Kind::early, asked.address);
    }
  }
  if (parts_.is_unreached(response)) {
    note_unreached(job, now);
    return;
  }
  if (end.shows_no_echo) {
    std::ranges::for_each(parts_.devices.entries(), &Hold::note_no_echo, &DeviceEntry::hold);
  }
  entry.note_heard();
  entry.unreached.reset();
  entry.hold.note_answered(sent_of(job, *entry.device, end.due), response.bytes(), end.took, now,
                           entry.in_force());
  parts_.payback.note_answered(asked.address, now);
  entry.health.note_answered(job.sent.last_at);
  diagnosis_.note_heard(asked.address, now);
  diagnosis_.note_times(job, end, now);
}

void Outcomes::handle_response(Job& job, const LineEnd& end, Instant now) {
  const Transaction& asked = job.transaction();
  const modbus::Pdu& response = *asked.response;
  DeviceEntry& entry = parts_.devices[asked.address];
  const bool exception = response.is_exception();
  take_response(job, end, now);
  if (job.is_single_read()) {
    for (Job* follower : job.sent.followers) {
      follower->transaction().response = response;
      follower->current = follower->transactions.size();
      ++parts_.counters.shared_reads;
    }
  }
  const Transaction& own = job.transaction();
  if (own.must_hold != nullptr && !holds_what_it_must(own)) {
    ends_.finish(job, is_passing(response) ? Ending::no_answer : Ending::mismatched);
    return;
  }
  if (exception && !(job.is_stop() && entry.device->has_accepted(response))) {
    parts_.acknowledged.forget(asked.address);
    if (!job.is_stop() || !repeat_refused(job, now)) {
      ends_.finish(job, Ending::answered);
    }
    return;
  }
  if (!asked.request.is_read()) {
    entry.failed_stop.reset();
  }
  note_stopped(job, now);
  entry.hold_booting(own.boot_time, now);  // though it has answered before
  remember(job);
  ends_.advance(job, Ending::answered);
}

// Other settings, which came meanwhile, may expect the question's register to hold something else,
// or ask another one.
bool Outcomes::holds_what_it_must(const Transaction& question) {
  DeviceEntry& entry = parts_.devices[question.address];
  const auto setting = register_of(*question.response);
  const bool holds = setting && std::ranges::count(*question.must_hold, *setting) > 0;
  const bool is_asked = is_still_asked(*entry.device, question);
  entry.setting_known = holds && is_asked;
  if (is_asked) {
    entry.setting = setting;
  }
  return holds;
}

void Outcomes::handle_silence(Job& job, const LineEnd& end, Instant now) {
  const Transaction& sent = job.transaction();
  DeviceEntry& entry = parts_.devices[sent.address];
  entry.setting_known = false;
  entry.cache.clear();
  entry.unreached.reset();
  if (sent.may_stay_silent()) {
    parts_.probes.note_unanswered(job, now);
    entry.hold_booting(sent.boot_time, now);
    ends_.advance(job, Ending::transmitted);
    return;
  }
  ++parts_.counters.timeouts;
  ++entry.counters.timeouts;
  entry.hold.note_unanswered(sent_of(job, *entry.device, end.due, end.may_be_echo));
  entry.stop_unanswered = entry.stop_unanswered || job.is_stop();
  // A probe that has brought an answer is not unanswered, though that may be another one's.
  if (is_cut(job, end, now) || (job.sent.is_probe && !entry.health.is_offline())) {
    parts_.probes.note_unanswered(job, now);
  } else if (!end.may_be_echo) {
    note_unanswered(job, end.due, now);
  }
  handle_failure(job, now);
}

void Outcomes::handle_unreadable(Job& job, const LineEnd& end, Instant now) {
  const Transaction& sent = job.transaction();
  DeviceEntry& entry = parts_.devices[sent.address];
  entry.hold.note_unanswered(sent_of(job, *entry.device, end.due), true);
  if (end.how == LineEnd::How::damaged) {
    ++parts_.counters.bad_crcs;
    ++entry.counters.bad_crcs;
    entry.health.note_damaged(now);
    // The frame may have been one of two, as a misfit may (LineDiagnosis::note_misfit).
    entry.free_at = std::max(entry.free_at, now + entry.hold.pace().longest_answer());
  } else {
    entry.hold.note_heard(now);
    diagnosis_.note_heard(sent.address, now);
  }
  entry.note_heard();
  entry.hold_booting(sent.boot_time, now);  // it may have carried out what it was told
  parts_.probes.note_unanswered(job, now);
  handle_failure(job, now);
}

void Outcomes::handle_failure(Job& job, Instant now) {
  const Transaction& own = job.transaction();
  parts_.acknowledged.forget(own.address);
  if (job.is_stop()) {
    handle_stop_failure(job, now);
    return;
  }
  const DeviceEntry& entry = parts_.devices[own.address];
  const bool may_repeat =
      (own.request.is_read() || entry.in_force().retry_writes) && !entry.health.is_offline();
  if (!may_repeat || job.sent.tries > entry.in_force().retries) {
    ends_.finish(job, Ending::no_answer);
  }
}

// What was read may answer the next one that asks, where the device allows it.
void Outcomes::remember(const Job& job) {
  const Transaction& transaction = job.transaction();
  DeviceEntry& entry = parts_.devices[transaction.address];
  if (job.is_single_read() && entry.device->cache > Duration{0} &&
      ReadCache::can_hold(transaction.request) && !transaction.response->is_exception()) {
    entry.cache.put(transaction, job.sent.first_at, job.sent.writes_before);
  }
}

void Outcomes::note_lost(Instant now) {
  const auto due = parts_.line.response_due();
  for (const Job* running : parts_.transmissions.running()) {
    const Transaction& sent = running->transaction();
    if (!running->sent.in_flight) {
      continue;
    }
    if (sent.is_broadcast()) {
      parts_.devices.hold_booting(sent, now);
    } else if (DeviceEntry& entry = parts_.devices[sent.address]; sent.may_stay_silent()) {
      entry.hold_booting(sent.boot_time, now);
    } else if (due) {
      entry.hold.note_unanswered(sent_of(*running, *entry.device, *due + running->sent.hurried_by));
    }
  }
}

}  // namespace mbgate::bus
