// SPDX-License-Identifier: Apache-2.0
#include "bus/health/probes.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::bus {
namespace {

constexpr int kPercent = 100;

/// So long may a request to an offline device wait for others of its kind: what a client waits for
/// a silent device anyway.
constexpr Duration kLongestProbing = std::chrono::seconds(1);

}  // namespace

// Offline devices take turns: the one that was asked longest ago goes first, if anybody still asks
// for it. While nobody else asks, some may wait for their turn, so that the bus is never idle.
bool Probes::may_ask(const Job& job, Instant now) const {
  const DeviceEntry& entry = devices_[job.address()];
  const bool freely = nobody_else_asks(now);
  if (entry.probe != nullptr || (!freely && now < next_at_) || now < entry.health.probe_at()) {
    return false;
  }
  const auto ahead = std::ranges::count_if(devices_.entries(), [&](const DeviceEntry& other) {
    const bool goes_first = other.health.is_offline() &&
                            other.health.probe_at() < entry.health.probe_at() &&
                            now < other.health.wanted_at() + other.in_force().probe_interval;
    return other.probe != nullptr || goes_first;
  });
  return ahead < (freely ? std::max<std::int64_t>(
                               kLongestProbing / entry.in_force().probe_timeout_or_default(), 1)
                         : 1);
}

bool Probes::note_accepted(Job& job, Instant now) {
  DeviceEntry& entry = devices_[job.address()];
  if (!entry.health.is_offline() || job.job_class == JobClass::stop || job.is_broadcast()) {
    ++others_;
    return false;
  }
  entry.probe = &job;
  job.probes_freely = nobody_else_asks(now);
  free_ += job.probes_freely ? 1U : 0U;
  return true;
}

void Probes::note_released(Job& job, Instant at) {
  free_ -= std::exchange(job.probes_freely, false) ? 1U : 0U;
  DeviceEntry& entry = devices_[job.address()];
  if (entry.probe == &job) {
    entry.probe = nullptr;
  } else {
    --others_;
    others_gone_at_ = at;
  }
}

void Probes::note_unanswered(const Transmission& probe, Instant now) {
  DeviceEntry& entry = devices_[probe.on_wire().address];
  if (!probe.is_probe || !entry.health.is_offline()) {
    return;  // the device was heard meanwhile
  }
  entry.health.set_probe_at(probe.last_sent + entry.in_force().probe_interval);
  // A shorter one that went while nobody else asked leaves the share of a longer one.
  const Duration took = now - probe.last_sent;
  next_at_ = std::max(next_at_, probe.last_sent + took * kPercent / settings_.probe_share);
}

void Probes::expect_others(Instant now) {
  next_at_ = now;
  for (DeviceEntry& entry : devices_.entries()) {
    if (entry.health.is_offline()) {
      entry.health.set_probe_at(now);
    }
  }
}

}  // namespace mbgate::bus
