// SPDX-License-Identifier: Apache-2.0
// From one generation of settings to the next, without taking anything away from what goes on.
#include <algorithm>

#include "gateway/gateway.hpp"

namespace mbgate::gateway {
namespace {

// Does a request that was made for the old address mean something else there now? A device that
// appears where none was counts, and one that is gone.
bool means_otherwise(const drive::Device* old, const drive::Device* next) {
  if (old == nullptr || next == nullptr) {
    return old != next;
  }
  return old->name != next->name || !next->understands_as(*old);
}

const drive::Device* device_at(const SettingsSnapshot& snapshot, BusId bus, std::uint8_t address) {
  const auto place = snapshot.devices.at(bus, address);
  return place ? &snapshot.settings.devices[*place] : nullptr;
}

bool same_failsafe(const SettingsSnapshot& old, std::size_t old_place, const SettingsSnapshot& next,
                   std::size_t place) {
  return std::ranges::equal(old.failsafe(old_place), next.failsafe(place), {},
                            &modbus::Request::pdu, &modbus::Request::pdu);
}

}  // namespace

void Gateway::handle_settings(Settings settings, Instant now) {
  if (stopping_) {
    return;
  }
  SettingsSnapshot& old = current();
  ++old.exchanges;  // it must not go before its last request has been looked at
  const SettingsDiff diff(old.settings, settings);
  close_unwanted(settings, diff, now);
  snapshots_.emplace_back(std::move(settings));
  end_changed(old, diff);
  renumber_clients(diff, now);
  renumber_devices(old, diff, now);
  replace_buses(old.settings, diff, now);
  unrouted_told_.clear();
  --old.exchanges;
  forget_generations();
  settle(now);
}

void Gateway::close_unwanted(const Settings& next, const SettingsDiff& diff, Instant now) {
  std::vector<ClientId> unwanted;
  for (const auto& [client, session] : sessions_) {
    const auto listener = diff.listener(session.info().listener);
    const auto* allow = listener ? &next.listener(*listener).allow : nullptr;
    const bool allowed =
        allow != nullptr && (allow->empty() || routing::contains(*allow, session.info().address));
    if (!allowed) {
      unwanted.push_back(client);
    }
    if (listener && !allowed) {
      report(ClientRefused{*listener, session.info().address, RefusalReason::not_allowed});
    }
  }
  for (const ClientId client : unwanted) {
    take_stops_ahead(client, sessions_.at(client), now, true);
    close(client);
  }
}

// Jobs for devices that are no longer what they were: what waits is taken back, what is on the wire
// is the last of its job. Stops are sent: settings do not move a drive, and the one that was meant
// is still where it was. The buses have their old numbers.
void Gateway::end_changed(const SettingsSnapshot& old, const SettingsDiff& diff) {
  std::vector<Exchange::Part> changed;
  for (Exchange& exchange : exchanges_.all()) {
    for (const Exchange::Part& part : exchange.parts) {
      if (!part.is_stop() && diff.keeps_line(part.bus) && is_changed(exchange, part, old, diff)) {
        changed.push_back(part);
      }
    }
  }
  for (const Exchange::Part& part : changed) {
    end_unsent(part);
  }
}

bool Gateway::is_changed(const Exchange& exchange, const Exchange::Part& part,
                         const SettingsSnapshot& old, const SettingsDiff& diff) const {
  const BusId bus = *diff.bus(part.bus);
  const auto listener = exchange.client_gone ? std::nullopt : diff.listener(exchange.listener);
  if (listener && leads_elsewhere(*listener, exchange, part, bus)) {
    return true;
  }
  const auto is_other = [&](std::uint8_t address) {
    return means_otherwise(device_at(old, part.bus, address), device_at(current(), bus, address));
  };
  if (part.job->is_broadcast()) {
    for (std::size_t address = 0; address < DeviceIndex::kAddresses; ++address) {
      if (is_other(static_cast<std::uint8_t>(address))) {
        return true;
      }
    }
    return false;
  }
  const routing::ResolvedRoute* resolved =
      listener ? current().routes.find(*listener, exchange.header.unit) : nullptr;
  const bool other_order = resolved != nullptr && resolved->route.word_order != exchange.word_order;
  return other_order || is_other(part.job->transactions.front().address);
}

// Its unit is another device's now, or nobody's. The bus has its new number.
bool Gateway::leads_elsewhere(ListenerId listener, const Exchange& exchange,
                              const Exchange::Part& part, BusId bus) const {
  const std::uint8_t unit = exchange.header.unit;
  const routing::ResolvedRoute* resolved = current().routes.find(listener, unit);
  if (resolved == nullptr || settings().own_unit == unit ||
      resolved->is_broadcast() != part.job->is_broadcast()) {
    return true;
  }
  return resolved->is_broadcast()
             ? std::ranges::find(resolved->route.buses, bus) == resolved->route.buses.end()
             : resolved->route.buses.front() != bus ||
                   resolved->route.address_of(unit) != part.job->transactions.front().address;
}

void Gateway::replace_buses(const Settings& old, const SettingsDiff& diff, Instant now) {
  auto before = std::exchange(buses_, {});
  buses_.resize(settings().buses.size());
  for (const BusId id : std::exchange(dirty_buses_, {})) {
    before[static_cast<std::size_t>(id)]->dirty = false;  // under this number
  }
  for (Exchange& exchange : exchanges_.all()) {
    for (Exchange::Part& part : exchange.parts) {
      part.bus = diff.bus(part.bus).value_or(kNoBus);
    }
  }
  for (std::size_t place = 0; place < old.buses.size(); ++place) {
    const BusId old_id{static_cast<std::uint32_t>(place)};
    const auto id = diff.bus(old_id);
    if (diff.keeps_line(old_id)) {
      buses_[static_cast<std::size_t>(*id)] = std::move(before[place]);
      touch(*id).update(settings().bus(*id), settings().devices_on(*id), now);
      continue;
    }
    end_dead(before[place]->bus, now);
    if (id) {
      line_actions_.push(Shut{*id});
    }
  }
  for (std::size_t place = 0; place < buses_.size(); ++place) {
    if (buses_[place] == nullptr) {
      const BusId id{static_cast<std::uint32_t>(place)};
      buses_[place] = std::make_unique<BusSlot>(settings().bus(id), settings().devices_on(id));
      touch(id).start();
    }
  }
}

// Its line is given up: what was on the wire ends, and what waits. Nobody needs its news any more.
void Gateway::end_dead(bus::Bus& dead, Instant now) {
  dead.handle_lost(now);
  while (const auto action = dead.poll()) {
    if (const auto* ended = std::get_if<bus::JobEnded>(&*action)) {
      end_part(*ended->job, ended->ending);
    }
  }
}

void Gateway::renumber_clients(const SettingsDiff& diff, Instant now) {
  for (Exchange& exchange : exchanges_.all()) {
    // Of a client that has gone nobody asks.
    if (exchange.snapshot != nullptr && !exchange.client_gone) {
      exchange.listener = *diff.listener(exchange.listener);
    }
  }
  listener_clients_.assign(settings().listeners.size(), 0);
  for (auto& [client, session] : sessions_) {
    const ListenerId listener = *diff.listener(session.info().listener);
    session.adopt(listener, settings().listener(listener));
    session.ahead.renumber([&](std::size_t device) { return diff.device(device); });
    ++listener_clients_[static_cast<std::size_t>(listener)];
    if (session.listener().idle_timeout > Duration{0}) {
      arm(client, session, now + session.listener().idle_timeout);
    }
    ready_clients_.push_back(client);
  }
  for (auto& [address, source] : sources_) {
    source.weight = weight_of(address);
  }
}

void Gateway::renumber_devices(const SettingsSnapshot& before, const SettingsDiff& diff,
                               Instant now) {
  const std::size_t devices = settings().devices.size();
  const StopMarks marks = std::exchange(stop_marks_, StopMarks(devices));
  const Writers writers = std::exchange(writers_, Writers(devices));
  const Failsafe failsafe = std::exchange(failsafe_, current().new_failsafe());
  for (const auto& [client, session] : sessions_) {
    failsafe_.client_came(client, current().watched_for(session.info(), session.rights()));
    if (session.has_asked) {
      failsafe_.client_asked(client, now);
    }
    // Its answers may have come of this reload: its silence begins then.
    failsafe_.client_waits(client, failsafe.does_wait(client), now);
  }
  for (std::size_t old = 0; old < marks.size(); ++old) {
    if (const auto place = diff.device(old)) {
      stop_marks_.carry(*place, marks, old);
      writers_.carry(*place, writers, old);
      failsafe_.carry(*place, failsafe, old, same_failsafe(before, old, current(), *place));
    }
  }
  for (Exchange& exchange : exchanges_.all()) {
    if (!exchange.failsafe) {
      continue;
    }
    FailsafeRun& run = *exchange.failsafe;
    const auto place = diff.device(run.due.device);
    if (!place || current().failsafe(*place).empty()) {
      exchange.failsafe.reset();  // nobody asks any more
      continue;
    }
    run.is_outdated = run.is_outdated || !same_failsafe(before, run.due.device, current(), *place);
    run.due.device = *place;
  }
}

}  // namespace mbgate::gateway
