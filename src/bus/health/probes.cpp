// SPDX-License-Identifier: Apache-2.0
#include "bus/health/probes.hpp"

#include <algorithm>

namespace mbgate::bus {

// Offline devices take turns: the one that was asked longest ago goes first, if anybody still asks
// for it, and it may be asked.
bool Probes::may_ask(const Job& job, Instant now) const {
  const DeviceEntry& entry = devices_[job.address()];
  const bool others_ask = others_ > 0 || now < others_gone_at_ + settings_.timing.probe_interval;
  if (now < entry.probe_at || (others_ask && now < next_at_)) {
    return false;
  }
  const auto goes_first = [&](const DeviceEntry& other) {
    return other.probe_at < entry.probe_at &&
           now < other.wanted_at + other.in_force().probe_interval && now >= other.free_at &&
           (settings_.has_identifiers() || now >= other.hold.until(other.in_force()));
  };
  return std::ranges::none_of(devices_.entries(), [&](const DeviceEntry& other) {
    return other.health.is_offline() && (other.probe != nullptr || goes_first(other));
  });
}

void Probes::note_accepted(Job& job) {
  DeviceEntry& entry = devices_[job.address()];
  if (!entry.health.is_offline() || job.is_stop() || job.is_broadcast()) {
    ++others_;
  } else {
    entry.probe = &job;
  }
}

void Probes::note_released(const Job& job, Instant at) {
  DeviceEntry& entry = devices_[job.address()];
  if (entry.probe == &job) {
    entry.probe = nullptr;
  } else {
    --others_;
    others_gone_at_ = at;
  }
}

void Probes::note_unanswered(const Job& probe, Instant now) {
  DeviceEntry& entry = devices_[probe.transaction().address];
  if (!probe.sent.is_probe || !entry.health.is_offline()) {
    return;  // the device was heard meanwhile
  }
  entry.probe_at = probe.sent.last_at + entry.in_force().probe_interval;
  constexpr int kPercent = 100;
  // A shorter one that went while nobody else asked leaves the share of a longer one.
  const Duration took = now - probe.sent.last_at;
  next_at_ = std::max(next_at_, probe.sent.last_at + took * kPercent / settings_.probe_share);
}

void Probes::expect_others(Instant now) {
  next_at_ = now;
  for (DeviceEntry& entry : devices_.entries()) {
    if (entry.health.is_offline()) {
      entry.probe_at = now;
    }
  }
}

}  // namespace mbgate::bus
