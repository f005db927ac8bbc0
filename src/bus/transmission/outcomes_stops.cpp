// SPDX-License-Identifier: Apache-2.0
// What it means that nobody has answered; and what the end of a stop's transmission means: it
// counts as carried out, is repeated, or is given up. What becomes of those that a close has cut.
#include <algorithm>
#include <array>

#include "bus/transmission/outcomes.hpp"

namespace mbgate::bus {
namespace {

// At an address that no [[device]] has, and that was never heard, there may be nobody.
unsigned offline_after(const DeviceEntry& entry) {
  const unsigned usual = entry.in_force().offline_after;
  return entry.is_unknown() ? std::min(usual, 1U) : usual;
}

bool may_be_tried_again(const Job& stop, const DeviceEntry& entry) {
  return !stop.is_abandoned() && stop.sent.tries <= entry.in_force().stop_retries;
}

}  // namespace

bool is_passing(const modbus::Pdu& response) {
  using Code = modbus::ExceptionCode;
  constexpr std::array kPassing = {Code::acknowledge, Code::server_device_busy,
                                   Code::gateway_path_unavailable,
                                   Code::gateway_target_failed_to_respond};
  return response.is_exception() &&
         std::ranges::count(kPassing, static_cast<Code>(response.bytes()[1])) > 0;
}

// Nothing came from the device; what is owed on a connection holds nothing.
void Outcomes::note_unreached(Job& job, Instant now) {
  const Transaction& sent = job.transaction();
  DeviceEntry& entry = parts_.devices[sent.address];
  entry.setting_known = false;
  entry.cache.clear();
  entry.unreached = sent.response->bytes()[1];
  note_unanswered(job, now, now);
}

void Outcomes::note_unanswered(Job& job, Instant due, Instant now) {
  const std::uint8_t address = job.transaction().address;
  DeviceEntry& entry = parts_.devices[address];
  parts_.payback.note_lost(job.sent.last_at, now);
  parts_.probes.note_unanswered(job, now);
  if (entry.health.note_unanswered(job.sent.last_at, due, offline_after(entry))) {
    entry.probe_at = now + entry.in_force().probe_interval;
    diagnosis_.notify(DeviceNotice::Kind::lost, address);
    ends_.end_waiting_for(address);
  }
}

// Not beside a write on a Modbus TCP connection, which the server may carry out after the stop.
void Outcomes::note_stopped(const Job& job, Instant now) {
  const Transaction& sent = job.transaction();
  const auto may_undo = [&](const Job* other) {
    return other->sent.in_flight && other->job_class == JobClass::write &&
           other->address() == sent.address;
  };
  const bool stops =
      sent.is_broadcast() || parts_.devices.is_stop(sent.address, sent.request, sent.broadcast);
  if (job.is_stop() && stops && std::ranges::none_of(parts_.transmissions.running(), may_undo)) {
    parts_.acknowledged.note(sent, now);
  }
}

// It is repeated behind other stops that wait, so that a dead device does not keep them waiting.
void Outcomes::handle_stop_failure(Job& stop, Instant now) {
  DeviceEntry& entry = parts_.devices[stop.transaction().address];
  const bool is_given_up = stop.sent.is_one_try && entry.stops_given_up;
  if (!is_given_up && may_be_tried_again(stop, entry)) {
    parts_.transmissions.leave(stop);
    stop.sent.waits_since = now;
    parts_.stops.push(stop);
    return;
  }
  entry.stops_given_up =
      entry.stop_unanswered && entry.health.unanswered_in_row() > entry.in_force().stop_retries;
  give_up_stop(stop, now);
}

// True: it is sent again. The drive may only be busy, or behind a gateway that is; another
// exception is its last word. Until then the drive is left alone, and the line is free for others.
bool Outcomes::repeat_refused(Job& stop, Instant now) {
  Transaction& sent = stop.transaction();
  DeviceEntry& entry = parts_.devices[sent.address];
  const std::uint8_t exception = sent.response->bytes()[1];
  if (is_passing(*sent.response) && may_be_tried_again(stop, entry)) {
    const Instant again_at = now + parts_.settings.stop_wait;
    sent.response.reset();
    entry.free_at = std::max(entry.free_at, again_at);
    parts_.transmissions.leave(stop);
    parts_.stops.rest(stop, again_at);
    return true;
  }
  ++parts_.counters.stops_unanswered;
  entry.failed_stop = FailedStop{now, exception};
  diagnosis_.notify(DeviceNotice::Kind::stop_refused, sent.address);
  return false;
}

void Outcomes::give_up_stop(Job& stop, Instant now) {
  part_from_untried(stop);
  parts_.devices[stop.transaction().address].failed_stop = FailedStop{now};
  ++parts_.counters.stops_unanswered;
  diagnosis_.notify(DeviceNotice::Kind::stop_unanswered, stop.transaction().address);
  ends_.finish(stop, Ending::no_answer);
}

// Those that joined it after its last transmission are still to be transmitted once.
void Outcomes::part_from_untried(Job& stop) {
  const auto untried = std::ranges::stable_partition(stop.sent.followers, &Job::was_on_wire);
  if (untried.empty()) {
    return;
  }
  Job& heir = *untried.front();
  heir.sent.waits_since = heir.accepted_at;
  heir.sent.followers.assign(untried.begin() + 1, untried.end());
  stop.sent.followers.erase(untried.begin(), untried.end());
  parts_.stops.push_in_order(heir);
}

void Outcomes::handle_cut_stops(Instant now) {
  const auto running = parts_.transmissions.running();
  for (Job* cut : std::vector(running.begin(), running.end())) {
    if (cut->is_stop() && std::exchange(cut->sent.in_flight, false)) {
      parts_.probes.note_unanswered(*cut, now);
      handle_failure(*cut, now);
    }
  }
}

// Nobody knows whether the server has done what was on its way. A read does no harm if it is done
// twice; if the next connection is closed too before its answer, it has failed.
void Outcomes::handle_cut(Instant now) {
  handle_cut_stops(now);
  const auto running = parts_.transmissions.running();
  for (Job* cut : std::vector(running.begin(), running.end())) {
    if (!std::exchange(cut->sent.in_flight, false)) {
      continue;
    }
    parts_.probes.note_unanswered(*cut, now);
    const std::size_t current = cut->current;
    if (cut->transaction().request.is_read() && !cut->sent.is_probe && cut->sent.cut != current) {
      cut->sent.cut = current;
    } else {
      ends_.finish(*cut, Ending::no_answer);
    }
  }
}

}  // namespace mbgate::bus
