// SPDX-License-Identifier: Apache-2.0
#include "gateway/writes/failsafe.hpp"

#include <algorithm>
#include <utility>

#include "gateway/limits.hpp"

namespace mbgate::gateway {

void Failsafe::client_came(ClientId client, const DevicePlaces& devices) {
  if (!devices.empty()) {
    clients_[client].devices = devices;
  }
}

DevicePlaces Failsafe::client_asked(ClientId client, Instant now) {
  DevicePlaces not_sent;
  const auto known = clients_.find(client);
  if (known == clients_.end()) {
    return not_sent;
  }
  const bool is_first = !std::exchange(known->second.has_asked, true);
  for (const std::size_t device : known->second.devices) {
    Watch& watch = watches_.at(device);
    watch.clients += is_first ? 1U : 0U;
    if (watch.pending && watch.pending->told) {
      not_sent.push_back(device);
    }
    watch.pending.reset();
    watch.again_at.reset();
    watch.armed = true;
    note_activity(watch, now);
  }
  return not_sent;
}

void Failsafe::client_waits(ClientId client, bool waits, Instant now) {
  const auto known = clients_.find(client);
  if (known == clients_.end() || known->second.waits == waits) {
    return;
  }
  known->second.waits = waits;
  for (const std::size_t device : known->second.devices) {
    Watch& watch = watches_.at(device);
    if (waits) {
      ++watch.waiting;
    } else {
      --watch.waiting;
      note_activity(watch, now);
    }
  }
}

void Failsafe::client_gone(ClientId client) {
  const auto known = clients_.find(client);
  if (known == clients_.end()) {
    return;
  }
  for (const std::size_t device : known->second.devices) {
    Watch& watch = watches_.at(device);
    watch.waiting -= known->second.waits ? 1U : 0U;
    watch.clients -= known->second.has_asked ? 1U : 0U;
    if (watch.clients == 0 && watch.armed) {
      set_due(device, watch, FailsafeReason::gone);
    }
    earliest_ = bus::earlier(earliest_, silent_at(watch));
  }
  clients_.erase(known);
}

std::optional<Failsafe::Due> Failsafe::take_due(Instant now) {
  const bool time_has_come = earliest_ && now >= *earliest_;
  if (returned_.empty() && due_.empty() && !time_has_come) {
    return std::nullopt;
  }
  for (const std::size_t device : std::exchange(returned_, {})) {
    Watch& watch = watches_.at(device);
    watch.again_at = now + kFailsafeRetry;
    earliest_ = bus::earlier(earliest_, watch.again_at);
  }
  if (earliest_ && now >= *earliest_) {
    look_at_times(now);
  }
  while (!due_.empty()) {
    Watch& watch = watches_.at(due_.front());
    due_.erase(due_.begin());
    watch.again_at.reset();
    if (watch.pending) {
      return std::exchange(watch.pending, std::nullopt);
    }
  }
  return std::nullopt;
}

void Failsafe::look_at_times(Instant now) {
  earliest_.reset();
  for (auto& [device, watch] : watches_) {
    const auto silent = silent_at(watch);
    if (silent && now >= *silent) {
      set_due(device, watch, FailsafeReason::silent);
    } else {
      earliest_ = bus::earlier(earliest_, silent);
    }
    if (watch.again_at && now >= *watch.again_at) {
      watch.again_at.reset();
      due_.push_back(device);
    }
    earliest_ = bus::earlier(earliest_, watch.again_at);
  }
}

bool Failsafe::put_back(Due due) {
  const auto watch = watches_.find(due.device);
  if (watch == watches_.end() || watch->second.armed) {
    return false;
  }
  auto& pending = watch->second.pending;
  if (!pending) {
    returned_.push_back(due.device);
    pending = std::move(due);
    return true;
  }
  // It was due once more: what was sent the first time only is not sent.
  std::erase_if(pending->sent, [&](std::size_t place) {
    return std::ranges::find(due.sent, place) == due.sent.end();
  });
  pending->told = pending->told || due.told;
  return true;
}

void Failsafe::line_is_back(std::size_t device) {
  if (const auto watch = watches_.find(device); watch != watches_.end() && watch->second.pending) {
    due_.push_back(device);
  }
}

std::optional<Failsafe::Due> Failsafe::take_last(std::size_t device, FailsafeReason reason) {
  const auto entry = watches_.find(device);
  if (entry == watches_.end()) {
    return std::nullopt;
  }
  Watch& watch = entry->second;
  if (std::exchange(watch.armed, false) && !watch.pending) {
    return Due{device, reason};
  }
  return std::exchange(watch.pending, std::nullopt);
}

std::optional<Instant> Failsafe::next() const { return earliest_; }

void Failsafe::carry(std::size_t device, const Failsafe& old, bool same_writes) {
  const auto entry = watches_.find(device);
  const auto before = old.watches_.find(device);
  if (entry == watches_.end() || before == old.watches_.end()) {
    return;
  }
  Watch& watch = entry->second;
  if (before->second.pending) {
    watch.pending = before->second.pending;
    if (!same_writes) {
      watch.pending->sent.clear();
    }
    due_.push_back(device);  // other settings may have brought its line back
  }
  // Who may write only by these settings has not asked since they were due.
  watch.active = before->second.active;
  watch.armed = before->second.armed;
  earliest_ = bus::earlier(earliest_, silent_at(watch));
  if (watch.clients == 0 && watch.armed) {
    set_due(device, watch, FailsafeReason::gone);
  }
}

void Failsafe::note_activity(Watch& watch, Instant now) {
  watch.active = now;
  earliest_ = bus::earlier(earliest_, silent_at(watch));
}

void Failsafe::set_due(std::size_t device, Watch& watch, FailsafeReason reason) {
  watch.armed = false;
  if (!watch.pending) {
    watch.pending = Due{device, reason};
  }
  due_.push_back(device);
}

std::optional<Instant> Failsafe::silent_at(const Watch& watch) {
  if (watch.quiet <= Duration{0} || watch.clients == 0 || watch.waiting > 0 || !watch.armed) {
    return std::nullopt;
  }
  return watch.active + watch.quiet;
}

}  // namespace mbgate::gateway
