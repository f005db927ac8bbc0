// SPDX-License-Identifier: Apache-2.0
#include "gateway/settings/settings_snapshot.hpp"

#include <algorithm>
#include <limits>

namespace mbgate::gateway {
namespace {

std::vector<routing::ListenerKind> kinds_of(const Settings& settings) {
  std::vector<routing::ListenerKind> kinds;
  kinds.reserve(settings.listeners.size());
  for (const auto& listener : settings.listeners) {
    const bool is_ascii =
        listener.bus && settings.bus(*listener.bus).line.framing == bus::Framing::ascii;
    kinds.push_back({listener.bus, listener.broadcast, listener.broadcast_reply,
                     listener.broadcast_mixed, !is_ascii});
  }
  return kinds;
}

bool reaches(const routing::ResolvedRoute& resolved, unsigned unit, const drive::Device& device) {
  if (resolved.is_broadcast()) {
    return std::ranges::any_of(resolved.audiences, [&](const routing::Audience& audience) {
      return audience.bus == device.bus;
    });
  }
  return resolved.route.buses.front() == device.bus &&
         device.stands_for(resolved.route.address_of(static_cast<std::uint8_t>(unit)));
}

}  // namespace

SettingsSnapshot::SettingsSnapshot(Settings given)
    : settings(std::move(given)),
      routes(kinds_of(settings), settings.routes, settings.devices),
      devices(settings.devices, settings.buses.size()) {
  for (std::size_t listener = 0; listener < settings.listeners.size(); ++listener) {
    DevicePlaces& watched = watched_.emplace_back();
    for (std::size_t place = 0; place < settings.devices.size(); ++place) {
      if (!failsafe(place).empty() &&
          leads_to(ListenerId{static_cast<std::uint32_t>(listener)}, settings.devices[place])) {
        watched.push_back(place);
      }
    }
  }
}

const DeviceGuard* SettingsSnapshot::guard(std::size_t device) const {
  return device < settings.guards.size() ? &settings.guards[device] : nullptr;
}

std::span<const modbus::Request> SettingsSnapshot::failsafe(std::size_t device) const {
  const DeviceGuard* known = guard(device);
  return known != nullptr ? std::span(known->failsafe) : std::span<const modbus::Request>();
}

Failsafe SettingsSnapshot::new_failsafe() const {
  Failsafe watches;
  for (std::size_t place = 0; place < settings.devices.size(); ++place) {
    if (!failsafe(place).empty()) {
      watches.watch(place, guard(place)->quiet);
    }
  }
  return watches;
}

DevicePlaces SettingsSnapshot::watched_for(const ClientInfo& client,
                                           routing::ClientRights rights) const {
  if (rights.read_only) {
    return {};
  }
  const auto is_denied_by_rules = [&](std::size_t place) {
    const routing::TouchedRegisters all{place, &settings.devices[place]};
    routing::AccessQuestion question{client.address, &client.role, client.listener};
    question.is_read = false;
    question.touched = std::span(&all, 1);
    question.ranges_known = false;
    return !routing::decide(settings.rules, question).permitted;
  };
  DevicePlaces places = watched_[static_cast<std::size_t>(client.listener)];
  const auto denied = std::ranges::remove_if(places, [&](std::size_t place) {
    const DeviceGuard& rules = *guard(place);
    const bool counts = rules.failsafe_clients.empty() ||
                        rules.failsafe_clients.contains(client.address, client.role);
    return !counts ||
           (rules.writer == WriterRule::listed &&
            !rules.writers.contains(client.address, client.role)) ||
           is_denied_by_rules(place);
  });
  places.erase(denied.begin(), denied.end());
  return places;
}

bool SettingsSnapshot::leads_to(ListenerId listener, const drive::Device& device) const {
  for (unsigned unit = 0; unit <= std::numeric_limits<std::uint8_t>::max(); ++unit) {
    const routing::ResolvedRoute* resolved = routes.find(listener, static_cast<std::uint8_t>(unit));
    if (resolved != nullptr && settings.status_unit != unit && resolved->route.may_write() &&
        reaches(*resolved, unit, device)) {
      return true;
    }
  }
  return false;
}

}  // namespace mbgate::gateway
