// SPDX-License-Identifier: Apache-2.0
#include "soak/failsafe_watch.hpp"

#include <algorithm>
#include <utility>

#include "soak/specification.hpp"

namespace mbgate::soak {

FailsafeWatch::FailsafeWatch(const SoakPlan& plan) : plan_(plan) {
  for (std::size_t device = 0; device < plan.settings.devices.size(); ++device) {
    const gateway::DeviceGuard& guard = plan.settings.guards[device];
    if (guard.failsafe.empty()) {
      continue;
    }
    const auto bus = static_cast<std::size_t>(plan.settings.devices[device].bus);
    Watch& watch = watches_.emplace_back();
    watch.door.device = device;
    watch.door.buses = {bus};
    watch.hosts = plan.writers[device];
    watch.is_listed = guard.writer == gateway::WriterRule::listed;
    watch.listeners.resize(plan.settings.listeners.size());
    for (const Door& door : plan.doors) {
      const bool leads = door.device ? door.device == device
                                     : std::ranges::find(door.buses, bus) != door.buses.end();
      const bool is_open = !door.read_only && !door.absent && !door.is_closed;
      watch.listeners[door.listener] = watch.listeners[door.listener] || (leads && is_open);
    }
  }
}

void FailsafeWatch::note_activity(Watch& watch, Instant now) {
  watch.active = now;
  if (quiet_of(watch) > Duration{0}) {
    next_ = std::min(next_, now + quiet_of(watch));
  }
}

void FailsafeWatch::came(ClientId client, std::size_t listener, unsigned host) {
  if (!watches_.empty()) {
    clients_[client] = {listener, host, watches_of(listener, host)};
  }
}

std::vector<std::size_t> FailsafeWatch::watches_of(std::size_t listener, unsigned host) const {
  std::vector<std::size_t> found;
  const auto& readers = plan_.readers[listener];
  if (std::ranges::find(readers, host) != readers.end()) {
    return found;
  }
  for (std::size_t at = 0; at < watches_.size(); ++at) {
    const Watch& watch = watches_[at];
    const bool listed =
        !watch.is_listed || std::ranges::find(watch.hosts, host) != watch.hosts.end();
    if (watch.listeners[listener] && listed &&
        lets_write_by_rules(plan_, listener, host, *watch.door.device)) {
      found.push_back(at);
    }
  }
  return found;
}

// Who may only read by now has gone, as far as writing goes; who may write by now has not asked
// yet.
void FailsafeWatch::after_reload() {
  std::vector<bool> were_any(watches_.size());
  for (std::size_t at = 0; at < watches_.size(); ++at) {
    were_any[at] = std::exchange(watches_[at].clients, 0) > 0;
    watches_[at].waiting = 0;
  }
  for (auto& [id, client] : clients_) {
    client.watches = watches_of(client.listener, client.host);
    for (const std::size_t at : client.watches) {
      watches_[at].clients += client.has_asked ? 1U : 0U;
      watches_[at].waiting += client.waits ? 1U : 0U;
    }
  }
  for (std::size_t at = 0; at < watches_.size(); ++at) {
    Watch& watch = watches_[at];
    watch.due = watch.due || (were_any[at] && watch.clients == 0 && !watch.sent);
    watch.sent = watch.sent || watch.due;
  }
  next_ = Instant::min();
  takes_turns_ = true;
}

std::vector<std::size_t> FailsafeWatch::asked(ClientId client, Instant now) {
  std::vector<std::size_t> devices;
  if (const auto entry = clients_.find(client); entry != clients_.end()) {
    const bool is_first = !std::exchange(entry->second.has_asked, true);
    for (const std::size_t at : entry->second.watches) {
      watches_[at].clients += is_first ? 1U : 0U;
      watches_[at].sent = watches_[at].due = false;
      note_activity(watches_[at], now);
      devices.push_back(*watches_[at].door.device);
    }
  }
  return devices;
}

void FailsafeWatch::waits(ClientId client, bool waits, Instant now) {
  const auto entry = clients_.find(client);
  if (entry == clients_.end() || entry->second.waits == waits) {
    return;
  }
  entry->second.waits = waits;
  for (const std::size_t at : entry->second.watches) {
    if (waits) {
      ++watches_[at].waiting;
    } else {
      --watches_[at].waiting;
      note_activity(watches_[at], now);
    }
  }
}

void FailsafeWatch::gone(ClientId client) {
  if (const auto entry = clients_.find(client); entry != clients_.end()) {
    for (const std::size_t at : entry->second.watches) {
      Watch& watch = watches_[at];
      watch.waiting -= entry->second.waits ? 1U : 0U;
      watch.clients -= entry->second.has_asked ? 1U : 0U;
      if (watch.clients == 0 && !watch.sent) {
        watch.sent = watch.due = true;
      }
      next_ = Instant::min();
    }
    clients_.erase(entry);
  }
}

void FailsafeWatch::add_writes(std::vector<Asked>& due, const Watch& watch, Instant now) const {
  for (const PduBytes& write : plan_.failsafe[*watch.door.device]) {
    Asked& asked = due.emplace_back();
    asked.kind = Kind::stop;
    asked.failsafe = true;
    asked.is_repeated = spec::word_at(write, 1) == kStopRegister;
    asked.client_gone = true;
    asked.door = &watch.door;
    asked.pdu = write;
    asked.written = asked.earliest = now;
    asked.pieces.push_back({watch.door.buses.front(), address_of(watch), write, 0, false, false});
  }
}

std::optional<Instant> FailsafeWatch::silent_at(const Watch& watch) const {
  const Duration quiet = quiet_of(watch);
  const bool may_be = quiet > Duration{0} && watch.clients > 0 && watch.waiting == 0;
  return may_be && !watch.sent ? std::optional(watch.active + quiet) : std::nullopt;
}

bool FailsafeWatch::is_armed(std::size_t device) const {
  return std::ranges::any_of(
      watches_, [&](const Watch& watch) { return watch.door.device == device && !watch.sent; });
}

// To those that somebody may have written to since.
std::vector<Asked> FailsafeWatch::take_at_exit(Instant now) {
  std::vector<Asked> due;
  for (Watch& watch : watches_) {
    if (!std::exchange(watch.sent, true) &&
        plan_.settings.guards[*watch.door.device].failsafe_on_exit) {
      add_writes(due, watch, now);
    }
  }
  return due;
}

std::vector<Asked> FailsafeWatch::take_due(Instant now) {
  std::vector<Asked> due;
  if (takes_turns_ || now < next_) {
    return due;
  }
  next_ = Instant::max();
  for (Watch& watch : watches_) {
    const auto silent = silent_at(watch);
    if (silent && now >= *silent) {
      watch.sent = watch.due = true;
    } else {
      next_ = std::min(next_, silent.value_or(next_));
    }
    if (watch.due) {
      add_writes(due, watch, now);
    }
    watch.due = false;
  }
  return due;
}

}  // namespace mbgate::soak
