// SPDX-License-Identifier: Apache-2.0
// The bus: who waits, who is on the wire, what is known of the devices.
#include "explore/state_reader_parts.hpp"

namespace mbgate::explore {

void StateReader::read(bus::Bus& bus, gateway::Gateway& gateway, Hash& hash) {
  auto& [parts, listens_first_until, ends, diagnosis, outcomes, dispatch, sequence] = bus;
  hash.until(listens_first_until.value_or(hash.now()));
  // Settings: settings. Counted only: counters. Watches real adapters only: adapter. For the trace:
  // is_traced. Empty when the machine was asked for its actions: actions.
  auto& [settings, devices, counters, line, queue, transmissions, stops, acknowledged, last_sent,
         payback, probes, adapter, link, stopping, is_traced, pumped_at, actions] = parts;
  // Told only: diagnosis. They know nothing of their own: ends, outcomes, scheduler.
  const auto& [of_dispatch, its_ends, its_outcomes, its_diagnosis, scheduler, next_wake, looking] =
      dispatch;
  bool may_be_offline = false;
  for (const drive::Device& device : devices.devices()) {
    may_be_offline = may_be_offline || device.timing.offline_after != 0;
  }
  const Sight sight{!stops.empty(), may_be_offline, settings.frame_slack_or_default()};
  hash.add(stopping);
  hash.add(looking);
  hash.ordered(Order::acceptance, sequence);
  read(last_sent, settings, sight, hash);
  const auto& [paid_until, last_answered, answered_at, other_answered_at] = payback;
  hash.until(paid_until);
  hash.add(last_answered);
  hash.since(answered_at, settings.timing.probe_interval);
  hash.since(other_answered_at, settings.timing.probe_interval);
  // Perhaps a deadline that nothing comes near to; a longer wait can be read from its reasons.
  hash.until(
      std::min(next_wake ? next_wake->at : Instant::max(), hash.now() + std::chrono::seconds(1)));
  const auto& [of_settings, of_devices, next_probe, others, others_gone_at] = probes;
  hash.add(others);
  if (may_be_offline) {
    hash.until(next_probe);
    hash.since(others_gone_at, settings.timing.probe_interval);
    hash.since(pumped_at, settings.timing.probe_interval);  // the others may be gone since then
  }
  read(link, hash);
  // A setting: room.
  const auto& [room, running] = transmissions;
  hash.add(running.size());
  for (const bus::Job* leader : running) {
    read_leader(*leader, devices, gateway, hash);
  }
  read(queue, gateway, hash);
  const auto& [waiting_stops, resting_stops] = stops;
  require(resting_stops.empty(), "no stop is refused");
  hash.add(waiting_stops.size());
  for (const bus::Job& stop : waiting_stops) {
    read_leader(stop, devices, gateway, hash);
  }
  for (const auto& [sent, at] : acknowledged.stops_) {
    require(sent.unit == sent.address, "no device has every unit");
    hash.add(sent.address);
    hash.add(sent.is_broadcast());
    hash.add(sent.request.pdu().bytes());
    hash.since(at, bus::kStopCountsFor);
  }
  read(devices, sight, hash);
  read(line, sight, hash);
}

void StateReader::read(const bus::LastSent& sent, const bus::BusSettings& settings,
                       const Sight& sight, Hash& hash) {
  const auto& [writes_in_row, last_stop, last_end] = sent;
  hash.add(std::min(writes_in_row, settings.burst));
  hash.add(last_stop.value_or(0));
  if (sight.stop_waits) {
    hash.since(last_end, settings.stop_wait);
  }
}

void StateReader::read(const bus::LinkState& link, Hash& hash) {
  // Only after a loss: opened_at, delay, tried_at, left_at.
  const auto& [state, opened_at, reopen_at, delay, tried_at, left_at] = link;
  require(link.is_open() && !reopen_at, "the line is never lost");
  hash.add(state);
}

// Sources that nobody waits for begin anew; `by_deadline` says of the same jobs in which order they
// are looked at.
void StateReader::read(const bus::BusQueue& queue, gateway::Gateway& gateway, Hash& hash) {
  const auto& [limit, sources, round, by_deadline, writes] = queue;
  hash.add(round.size());
  for (const bus::BusQueue::Source& source : round) {
    const auto& [round_hook, waiting, weight, turns] = source;
    hash.add(weight);
    hash.add(turns);
    hash.add(waiting.size());
    for (const bus::Job& job : waiting) {
      read(&job, gateway, hash);
    }
  }
  for (const bus::Job& job : by_deadline) {
    hash.name(&job);
  }
  hash.add(writes);
}

void StateReader::read_leader(const bus::Job& leader, const bus::DeviceTable& devices,
                              gateway::Gateway& gateway, Hash& hash) {
  // No line is lost: cut.
  const auto& [followers, tries, cut, in_flight, is_probe, is_one_try, hurried_by, waits_since,
               first_at, last_at, writes_before] = leader.sent;
  for (const bool flag : {in_flight, is_probe, is_one_try}) {
    hash.add(flag);
  }
  hash.add(tries);
  hash.add(hurried_by);
  hash.ordered(Order::turn, static_cast<std::uint64_t>(last_at.time_since_epoch().count()));
  if (leader.is_stop()) {  // only a stop asks how long it has waited
    hash.since(waits_since, kFarPast);
  }
  if (devices[leader.address()].device->cache > Duration{0}) {
    hash.since(first_at, kFarPast);
    hash.ordered(Order::cached_writes, writes_before);
  }
  if (is_probe) {
    hash.since(last_at, kFarPast);
  }
  read(&leader, gateway, hash);
  hash.add(followers.size());
  for (const bus::Job* follower : followers) {
    read(follower, gateway, hash);
  }
}

void StateReader::read(const bus::Job* job, gateway::Gateway& gateway, Hash& hash) {
  if (!hash.name(job)) {
    return;
  }
  // Where it is linked is told by who shows it: hooks. Read of those that lead: sent. A name only:
  // number.
  const auto& [queue_hook, deadline_hook, stop_hook, number, owner, source, weight, job_class,
               sequence, deadline, transactions, current, sent, accepted_at, was_on_wire, abandoned,
               overtaken, accepted] = *job;
  for (const bool flag : {was_on_wire, abandoned, overtaken, accepted}) {
    hash.add(flag);
  }
  hash.add(source);
  hash.add(weight);
  hash.add(job_class);
  hash.ordered(Order::acceptance, sequence);
  hash.add(current);
  if (job_class == bus::JobClass::stop) {  // it has no deadline, and may have to wait once more
    hash.since(accepted_at, kFarPast);
  } else {
    hash.deadline(deadline, accepted_at);
  }
  hash.add(transactions.size());
  for (const bus::Transaction& transaction : transactions) {
    read(transaction, hash);
  }
  read(gateway.exchanges_[owner], gateway, hash);
}

void StateReader::read(const bus::Transaction& transaction, Hash& hash) {
  // There is one bus: bus.
  const auto& [bus, address, unit, request, silence_is_success, broadcast, response, boot_time,
               must_hold] = transaction;
  require(must_hold == nullptr, "the gateway asks nothing of its own");
  hash.add(address);
  hash.add(unit);
  hash.add(request.pdu().bytes());
  hash.add(silence_is_success);
  hash.add(broadcast.has_value());
  hash.add(response.has_value());
  if (response) {
    hash.add(response->bytes());
  }
  hash.add(boot_time);
}

// Settings: longest. Addresses without a device are never asked, and no good frame has one.
void StateReader::read(const bus::DeviceTable& devices, const Sight& sight, Hash& hash) {
  const auto& [other, unused, known, longest, entries] = devices;
  for (const drive::Device& device : known) {
    read(*entries.at(device.address), sight, hash);
  }
}

void StateReader::read(const bus::DeviceEntry& entry, const Sight& sight, Hash& hash) {
  // A setting: device. Nobody else asks here: others_at. The queue shows it too: probe. Counted or
  // told only: counters, early_reported, second_reported, misfit_reported, pause_reported,
  // owed_until, asked_at, silence, times, second_at, second_read_at, setting, unreached,
  // failed_stop.
  const auto& [device, counters, health, hold, cache, free_at, probe, probe_at, wanted_at,
               setting_known, early_reported, stop_unanswered, stops_given_up, second_reported,
               misfit_reported, pause_reported, owed_until, others_at, asked_at, silence, times,
               second_at, second_read_at, setting, unreached, failed_stop] = entry;
  read(health, entry.in_force(), hash);
  read(hold, entry.in_force(), hash);
  read(cache, device->cache, hash);
  hash.until(free_at);
  hash.name(probe);
  hash.add(setting_known);
  hash.add(stop_unanswered);
  hash.add(stops_given_up);
  if (sight.may_be_offline && health.is_offline()) {
    hash.since(probe_at, kFarPast);
    hash.since(wanted_at, entry.in_force().probe_interval);
  }
}

void StateReader::read(const bus::DeviceHealth& health, const drive::DeviceTiming& timing,
                       Hash& hash) {
  // Of answered_sent only whether there is one, as all that may end was sent later. Shown only:
  // damaged_in_row, since.
  const auto& [unanswered_in_row, answered_sent, damaged_in_row, state, since] = health;
  if (timing.offline_after != 0) {
    hash.add(unanswered_in_row);
  }
  hash.add(health.answered_before_last());
  hash.add(health.is_offline());  // the others are told only, and since when
}

void StateReader::read(const bus::Hold& hold, const drive::DeviceTiming& timing, Hash& hash) {
  // What was learned is forgotten by the minute, which no small world lives: before, while_began,
  // learned_at.
  const auto& [unanswered, pending, limits_now, is_doubtful, is_decisive, suspected_now, held_until,
               held_since, pace, heard_at, tails, silent, rests_until, rested_at, answered,
               was_sudden, seconds, clean, longest_second] = hold;
  // No registers are slow, no reload shortens times, no line is TCP: limits, unit, is_slow,
  // ordinary.
  const auto& [lately, before, while_began, learned, learned_at] = pace;
  const auto& [longest, ordinary, shortest] = lately;
  require(before.longest == Duration{0}, "a short life");
  hash.add(unanswered.size());
  for (const bus::Hold::Unanswered& it : unanswered) {
    const auto& [asked, sent, due, is_unreadable, is_retry, may_be_answered, is_slow, unit, limits,
                 is_outdated, is_over, was_replaced, suspected] = it;
    hash.add(asked.pdu().bytes());
    hash.since(sent, kFarPast);
    hash.since(due, kFarPast);
    hash.add(is_unreadable);
    hash.add(may_be_answered);
    hash.add(is_outdated);
    hash.add(is_over);
    hash.add(was_replaced);
    hash.add(suspected);
  }
  hash.add(pending ? pending->pdu().bytes() : modbus::Bytes());
  hash.add(is_doubtful ? 2U : unsigned{is_decisive});
  hash.add(suspected_now);
  hash.add(held_until.has_value());
  hash.until(held_until.value_or(hash.now()));
  hash.since(held_since, kFarPast);
  hash.since(heard_at, kFarPast);
  hash.add(tails);
  std::ranges::for_each(silent, [&](Instant sent) { hash.since(sent, kFarPast); });
  hash.until(rests_until);
  hash.since(rested_at, kFarPast);
  hash.add(answered.size());
  for (const auto& [asked, unit, at] : answered) {
    hash.since(at, kFarPast);
    hash.add(asked.pdu().bytes());
  }
  hash.add(was_sudden);
  hash.add(seconds);
  hash.add(clean);
  hash.add(longest_second);
  hash.add(longest);
  hash.add(shortest);
  hash.add(std::max(learned, timing.quarantine_or_default()));  // the longer one is in force
}

void StateReader::read(const bus::ReadCache& cache, Duration age, Hash& hash) {
  const auto& [reads, accepted, ended] = cache;
  if (age == Duration{0}) {
    return;  // nothing is put in, nothing taken out
  }
  hash.add(reads.size());
  for (const auto& [asked, asked_at] : reads) {
    hash.add(asked.request.pdu().bytes());
    hash.add(asked.response->bytes());
    hash.since(asked_at, age + Duration{1});
  }
  hash.ordered(Order::cached_writes, accepted);
  hash.add(accepted - ended);
}

}  // namespace mbgate::explore
