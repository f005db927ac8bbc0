// SPDX-License-Identifier: Apache-2.0
#include "gateway/failsafe.hpp"

namespace mbgate::gateway {

void Failsafe::client_came(ClientId client, const DevicePlaces& devices, Instant now) {
  if (devices.empty()) {
    return;
  }
  clients_[client].devices = devices;
  for (const std::size_t device : devices) {
    Watch& watch = watches_.at(device);
    ++watch.clients;
    note_activity(watch, now);
  }
}

void Failsafe::client_asked(ClientId client, Instant now) {
  const auto known = clients_.find(client);
  if (known == clients_.end()) {
    return;
  }
  for (const std::size_t device : known->second.devices) {
    note_activity(watches_.at(device), now);
  }
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
    if (--watch.clients == 0 && !watch.sent) {
      watch.sent = true;
      due_.push_back({device, false});
    }
    earliest_silence_ = bus::earlier(earliest_silence_, silent_at(watch));
  }
  clients_.erase(known);
}

std::optional<Failsafe::Due> Failsafe::take_due(Instant now) {
  if (earliest_silence_ && now >= *earliest_silence_) {
    earliest_silence_.reset();
    for (auto& [device, watch] : watches_) {
      const auto at = silent_at(watch);
      if (at && now >= *at) {
        watch.sent = true;
        due_.push_back({device, true});
      } else {
        earliest_silence_ = bus::earlier(earliest_silence_, at);
      }
    }
  }
  if (due_.empty()) {
    return std::nullopt;
  }
  const Due due = due_.front();
  due_.erase(due_.begin());
  return due;
}

std::optional<Instant> Failsafe::next() const { return earliest_silence_; }

void Failsafe::carry(std::size_t device, const Failsafe& old, std::size_t old_device) {
  const auto watch = watches_.find(device);
  const auto before = old.watches_.find(old_device);
  if (watch == watches_.end() || before == old.watches_.end()) {
    return;
  }
  for (const Due& due : old.due_) {
    if (due.device == old_device) {
      due_.push_back({device, due.silence});
    }
  }
  if (before->second.clients == 0) {
    return;
  }
  watch->second.active = before->second.active;
  watch->second.sent = before->second.sent;
  earliest_silence_ = bus::earlier(earliest_silence_, silent_at(watch->second));
  if (watch->second.clients == 0 && !watch->second.sent) {
    watch->second.sent = true;
    due_.push_back({device, false});
  }
}

void Failsafe::note_activity(Watch& watch, Instant now) {
  watch.active = now;
  watch.sent = false;
  earliest_silence_ = bus::earlier(earliest_silence_, silent_at(watch));
}

std::optional<Instant> Failsafe::silent_at(const Watch& watch) {
  if (watch.quiet <= Duration{0} || watch.clients == 0 || watch.waiting > 0 || watch.sent) {
    return std::nullopt;
  }
  return watch.active + watch.quiet;
}

}  // namespace mbgate::gateway
