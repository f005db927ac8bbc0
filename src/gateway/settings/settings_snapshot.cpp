// SPDX-License-Identifier: Apache-2.0
#include "gateway/settings/settings_snapshot.hpp"

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

}  // namespace

SettingsSnapshot::SettingsSnapshot(Settings given)
    : settings(std::move(given)),
      routes(kinds_of(settings), settings.routes, settings.devices),
      devices(settings.devices, settings.buses.size()) {}

const DeviceGuard* SettingsSnapshot::guard(std::size_t device) const {
  return device < settings.guards.size() ? &settings.guards[device] : nullptr;
}

std::span<const modbus::Request> SettingsSnapshot::failsafe(std::size_t device) const {
  const DeviceGuard* known = guard(device);
  return known != nullptr ? std::span(known->failsafe) : std::span<const modbus::Request>();
}

}  // namespace mbgate::gateway
