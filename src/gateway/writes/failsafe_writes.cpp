// SPDX-License-Identifier: Apache-2.0
#include "gateway/writes/failsafe_writes.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::gateway {

FailsafeWrites::FailsafeWrites(const SettingsHistory& settings, Exchanges& exchanges,
                               WriteRules& rules, ActionQueue& actions)
    : settings_(settings), exchanges_(exchanges), rules_(rules), actions_(actions) {
  adopt(settings.in_force());
}

bool FailsafeWrites::Watch::is_under_way() const {
  return std::ranges::any_of(writes, [](const Write& it) { return it.exchange.has_value(); });
}

const DeviceGuard& FailsafeWrites::guard(std::size_t device) const {
  return settings_.in_force().guard(device);
}

bool FailsafeWrites::counts(std::size_t device, const Watch& watch, ClientId client) const {
  const auto known = watch.connections.find(client);
  if (known == watch.connections.end()) {
    return false;
  }
  const ClientSession& session = *known->second;
  const routing::ClientList& listed = guard(device).failsafe_clients;
  return listed.empty() ? watch.writer == session.key()
                        : listed.contains(session.info().address, session.info().role);
}

bool FailsafeWrites::does_one_count(std::size_t device, const Watch& watch) const {
  return std::ranges::any_of(watch.connections,
                             [&](const auto& it) { return counts(device, watch, it.first); });
}

// Then a client is not silent.
bool FailsafeWrites::is_waited_for(std::size_t device, const Watch& watch) const {
  return exchanges_.any_of([&](const Exchange& exchange) {
    return exchange.plan && counts(device, watch, exchange.client) &&
           std::ranges::any_of(exchange.plan->transactions(), [&](const auto& part) {
             const DevicePlaces reached = settings_.in_force().devices.reached_by(part);
             return std::ranges::count(reached, device) > 0;
           });
  });
}

std::optional<Instant> FailsafeWrites::acts_at(std::size_t device, const Watch& watch) const {
  if (watch.due) {
    return watch.is_under_way() ? std::nullopt : std::optional(watch.again);
  }
  const DeviceGuard& rules = guard(device);
  if (watch.gone_at) {
    return *watch.gone_at + rules.failsafe_grace;
  }
  const bool may_be_silent = watch.writer && rules.quiet > Duration{0};
  return may_be_silent && does_one_count(device, watch)
             ? std::optional(watch.active + std::max(rules.quiet, rules.failsafe_grace))
             : std::nullopt;
}

// Those of its devices that have failsafe writes.
template <typename Visit>
void FailsafeWrites::visit_reached(const routing::Plan& plan, Visit visit) {
  if (watches_.empty()) {
    return;
  }
  for (const drive::Transaction& part : plan.transactions()) {
    for (const std::size_t device : settings_.in_force().devices.reached_by(part)) {
      if (const auto watch = watches_.find(device); watch != watches_.end()) {
        visit(device, watch->second);
      }
    }
  }
}

void FailsafeWrites::client_asked(const ClientSession& client, const routing::Plan& plan,
                                  bool writes, Instant now) {
  visit_reached(plan, [&](std::size_t device, Watch& watch) {
    watch.connections.emplace(client.id(), &client);
    if (writes) {
      watch.active = watch.writer ? watch.active : now;  // no silence of before counts
      watch.writer = client.key();
      watch.is_written_to = true;
    }
    if (guard(device).quiet > Duration{0}) {
      earliest_ = bus::earlier(earliest_, now + guard(device).quiet);
    }
    if (!counts(device, watch, client.id())) {
      return;
    }
    watch.active = now;
    watch.gone_at.reset();
    if (watch.due && !stopping_) {
      if (std::exchange(watch.is_reported, false)) {
        report(settings_.settings().devices[device], watch, FailsafeOutcome::client_back);
      }
      abandon(watch);
    }
  });
}

void FailsafeWrites::abandon(Watch& watch) {
  for (const Write& write : watch.writes) {
    if (write.exchange) {
      exchanges_.abandon(*write.exchange);
    }
  }
  watch.due.reset();
  watch.writes.clear();
}

void FailsafeWrites::client_gone(ClientId client, Instant now) {
  for (auto& [device, watch] : watches_) {
    const bool counted = watch.writer && counts(device, watch, client);
    watch.connections.erase(client);
    if (counted && !does_one_count(device, watch)) {
      watch.gone_at = now;
      earliest_ = bus::earlier(earliest_, now + guard(device).failsafe_grace);
    }
  }
}

bool FailsafeWrites::send_due(Instant now) {
  if (!earliest_ || now < next()) {
    return false;
  }
  earliest_.reset();
  bool any_sent = false;
  for (auto& [device, watch] : watches_) {
    const auto at = acts_at(device, watch);
    any_sent = (at && now >= *at && act(device, watch, now)) || any_sent;
    earliest_ = bus::earlier(earliest_, acts_at(device, watch));
  }
  return any_sent;
}

bool FailsafeWrites::act(std::size_t device, Watch& watch, Instant now) {
  if (!watch.due && !watch.gone_at && is_waited_for(device, watch)) {
    watch.active = now;  // the answer is still to come
    return false;
  }
  if (!watch.due) {
    begin(device, watch, watch.gone_at ? FailsafeReason::gone : FailsafeReason::silent);
  }
  send(device, watch, now);
  return true;
}

void FailsafeWrites::begin(std::size_t device, Watch& watch, FailsafeReason reason) {
  watch.due = reason;
  watch.is_written_to = false;
  watch.again = Instant::min();
  watch.writes.assign(guard(device).failsafe.size(), {});
}

void FailsafeWrites::send(std::size_t place, Watch& watch, Instant now) {
  const drive::Device& device = settings_.settings().devices[place];
  rules_.note_own_stop(place, now);
  watch.again = now + device.timing.probe_interval;
  for (std::size_t at = 0; at < watch.writes.size(); ++at) {
    Write& write = watch.writes[at];
    if (!write.is_acknowledged) {
      const std::uint32_t index = write.exchange.emplace(exchanges_.open(std::nullopt));
      exchanges_[index].client_gone = true;
      bus::Job& job = exchanges_.add_job(index, device.bus, {}, now);
      job.job_class = bus::JobClass::stop;
      job.transactions.emplace_back(device.address, guard(place).failsafe[at]);
      exchanges_.submit(index, now);
    }
  }
}

void FailsafeWrites::ended(std::uint32_t index, Instant now) {
  const Exchange& exchange = exchanges_[index];
  if (exchange.plan) {
    visit_reached(*exchange.plan, [&](std::size_t device, Watch& watch) {
      if (counts(device, watch, exchange.client)) {
        watch.active = now;
      }
    });
    return;
  }
  for (auto& [device, watch] : watches_) {
    const auto write = std::ranges::find(watch.writes, index, &Write::exchange);
    if (write != watch.writes.end()) {
      const auto& answer = exchange.response;
      write->exchange.reset();
      write->is_acknowledged =
          exchange.ended_as == bus::Ending::transmitted ||  // it is never answered
          (answer && settings_.settings().devices[device].has_accepted(*answer));
      end_run(device, watch);
    }
  }
}

void FailsafeWrites::end_run(std::size_t place, Watch& watch) {
  const drive::Device& device = settings_.settings().devices[place];
  if (watch.is_under_way()) {
    return;
  }
  if (std::ranges::all_of(watch.writes, &Write::is_acknowledged)) {
    report(device, watch, FailsafeOutcome::acknowledged);
    Watch fresh;
    fresh.connections = std::move(watch.connections);
    fresh.writer = watch.is_written_to ? watch.writer : std::nullopt;
    watch = std::move(fresh);
  } else if (stopping_) {
    report(device, watch, FailsafeOutcome::given_up);
  } else {
    if (!std::exchange(watch.is_reported, true)) {
      report(device, watch, FailsafeOutcome::waits);
    }
    earliest_ = bus::earlier(earliest_, watch.again);
  }
}

void FailsafeWrites::send_at_exit(Instant now) {
  stopping_ = true;
  for (auto& [device, watch] : watches_) {
    if (watch.is_under_way()) {
      continue;
    }
    if (guard(device).failsafe_on_exit && watch.writer) {
      if (!watch.due) {
        begin(device, watch, FailsafeReason::exit);
      }
      send(device, watch, now);
    } else if (watch.due) {
      report(settings_.settings().devices[device], watch, FailsafeOutcome::given_up);
    }
  }
}

// What is due begins anew where the writes, or their line, are others now.
void FailsafeWrites::adopt(const SettingsSnapshot& before) {
  const SettingsSnapshot& next = settings_.in_force();
  const auto& devices = next.settings.devices;
  auto old = std::exchange(watches_, {});
  for (std::size_t device = 0; device < devices.size(); ++device) {
    if (!next.guard(device).failsafe.empty()) {
      watches_[device];
    }
  }
  for (auto& [place, watch] : old) {
    const drive::Device& device = before.settings.devices[place];
    const auto same = place_of_same_drive(before.settings, place, next.settings);
    const auto known = same ? watches_.find(*same) : watches_.end();
    const bool goes_on =
        known != watches_.end() && devices[*same].bus == device.bus &&
        keeps_line(before.settings, next.settings, device.bus) &&
        std::ranges::equal(before.guard(place).failsafe, next.guard(*same).failsafe, {},
                           &modbus::Request::pdu, &modbus::Request::pdu);
    const auto anew = goes_on ? std::nullopt : watch.due;
    if (!goes_on) {
      abandon(watch);
    }
    if (!same && watch.writer) {
      report(device, watch, FailsafeOutcome::device_gone);
    } else if (known != watches_.end()) {
      known->second = watch;
      if (anew) {
        begin(known->first, known->second, *anew);
      }
    }
  }
  earliest_ = watches_.empty() ? std::nullopt : std::optional(Instant::min());
}

void FailsafeWrites::report(const drive::Device& device, const Watch& watch,
                            FailsafeOutcome outcome) {
  actions_.push(Report{
      FailsafeNews{device.bus, device.address, watch.due.value_or(FailsafeReason::gone), outcome}});
}

}  // namespace mbgate::gateway
