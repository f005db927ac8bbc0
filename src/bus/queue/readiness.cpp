// SPDX-License-Identifier: Apache-2.0
#include "bus/queue/readiness.hpp"

#include <algorithm>

namespace mbgate::bus {

Instant held_until(const Parts& parts, const Job& job) {
  if (job.job_class == JobClass::stop) {
    return Instant::min();
  }
  const std::size_t next = next_transaction(parts, job);
  const Transaction& transaction = job.transactions[next];
  const DeviceEntry& entry = parts.devices[transaction.address];
  const bool repeats_read = job.leads != nullptr && job.leads->tries > 0 && next == job.current &&
                            transaction.request.is_read();
  const Duration recently = parts.settings.timing.probe_interval;
  const Instant free =
      entry.is_silent() && !transaction.is_broadcast()
          ? std::max(entry.free_at, parts.payback.until(transaction.address, recently))
          : entry.free_at;
  return parts.quarantines()
             ? std::max(free, entry.hold.until(transaction.request, entry.in_force(), repeats_read))
             : free;
}

bool is_held_back(const Parts& parts, const Job& job, Instant now) {
  return !job.transactions[next_transaction(parts, job)].is_broadcast() &&
         held_until(parts, job) > now;
}

Wake ready_at(const Parts& parts, const Job& job) {
  if (job.job_class == JobClass::stop) {
    return {parts.line.ready_for_stop_at(), true};
  }
  const Transaction& transaction = job.transactions[next_transaction(parts, job)];
  const Instant held = held_until(parts, job);
  const bool is_broadcast = transaction.is_broadcast();
  const drive::DeviceTiming& timing =
      is_broadcast ? parts.settings.timing : parts.devices[transaction.address].in_force();
  const Instant silent_at = parts.line.ready_at(timing.gap);
  const Instant at = is_broadcast ? silent_at : std::max(held, silent_at);
  return {at, held < at};
}

std::size_t next_transaction(const Parts& parts, const Job& job) {
  std::size_t next = job.current;
  while (job.transactions[next].must_hold != nullptr &&
         (job.job_class == JobClass::stop ||
          parts.devices[job.transactions[next].address].setting_known)) {
    ++next;
  }
  return next;
}

Transmission* in_the_way_of(const Parts& parts, const Job& stop) {
  const auto running = parts.transmissions.running();
  const auto found = std::ranges::find_if(running, [&](const Transmission* it) {
    return it->in_flight &&
           (parts.quarantines() || (it->is_stop() && it->leader->address() == stop.address()));
  });
  return found == running.end() ? nullptr : *found;
}

Duration time_before_stop(const Parts& parts, const Transaction& sent) {
  constexpr int kSafely = 2;  // times the longest answer of late to ordinary registers
  const DeviceEntry& entry = parts.devices[sent.address];
  return entry.in_force().response_wait +
         std::max(parts.settings.stop_wait, kSafely * entry.hold.pace().longest_ordinary());
}

bool is_given_up(const Parts& parts, const Transmission& stop) {
  return !stop.leader->is_broadcast() && stop.tries == 0 &&
         parts.devices[stop.leader->address()].stops_given_up;
}

Instant held_until(const Parts& parts, const Transmission& stop) {
  return is_given_up(parts, stop)
             ? parts.payback.until(stop.leader->address(), parts.settings.timing.probe_interval)
             : Instant::min();
}

bool may_cut(const Parts& parts, const Transmission& stop, Instant now) {
  return !is_given_up(parts, stop) && !parts.acknowledged.has(*stop.leader, now);
}

Instant stop_overdue_at(const Parts& parts, const Transmission& stop) {
  const LineSilence* silence = parts.line.silence();
  return silence == nullptr
             ? Instant::max()
             : std::max(stop.waits_since, silence->busy_since()) + stop_deadline(parts.settings);
}

}  // namespace mbgate::bus
