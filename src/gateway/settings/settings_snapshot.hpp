// SPDX-License-Identifier: Apache-2.0
// Settings with what is derived from them. A request keeps the snapshot that it was planned with,
// so a reload takes nothing away from it.
#pragma once

#include <list>
#include <span>
#include <vector>

#include "gateway/client.hpp"
#include "gateway/settings/device_index.hpp"
#include "gateway/writes/failsafe.hpp"
#include "routing/route_table.hpp"

namespace mbgate::gateway {

struct SettingsSnapshot {
  explicit SettingsSnapshot(Settings given);
  SettingsSnapshot(const SettingsSnapshot&) = delete;  // its parts refer to each other
  SettingsSnapshot& operator=(const SettingsSnapshot&) = delete;

  /// Nothing: the device has no rules of its own.
  [[nodiscard]] const DeviceGuard* guard(std::size_t device) const;
  /// The failsafe writes of a device; none if it has none.
  [[nodiscard]] std::span<const modbus::Request> failsafe(std::size_t device) const;
  /// A watch for every device that has failsafe writes.
  [[nodiscard]] Failsafe new_failsafe() const;
  /// The devices with failsafe writes that the client may write to by any route.
  [[nodiscard]] DevicePlaces watched_for(const ClientInfo& client,
                                         routing::ClientRights rights) const;

  Settings settings;
  routing::RouteTable routes;
  DeviceIndex devices;
  std::size_t exchanges = 0;  ///< that refer to it

 private:
  [[nodiscard]] bool leads_to(ListenerId listener, const drive::Device& device) const;

  /// By listener: devices with failsafe writes that a route with write access leads to.
  std::vector<DevicePlaces> watched_;
};

/// The settings in force, and older ones as long as requests that were planned with them are open.
class SettingsHistory {
 public:
  explicit SettingsHistory(Settings settings) { snapshots_.emplace_back(std::move(settings)); }

  [[nodiscard]] SettingsSnapshot& in_force() { return snapshots_.back(); }
  [[nodiscard]] const SettingsSnapshot& in_force() const { return snapshots_.back(); }
  [[nodiscard]] const Settings& settings() const { return in_force().settings; }
  /// Returns those that were in force before; they stay until forget_unused().
  const SettingsSnapshot& adopt(Settings next) {
    const SettingsSnapshot& before = in_force();
    snapshots_.emplace_back(std::move(next));
    return before;
  }
  void forget_unused() {
    if (snapshots_.size() > 1) {
      snapshots_.remove_if(
          [this](const SettingsSnapshot& it) { return it.exchanges == 0 && &it != &in_force(); });
    }
  }

 private:
  friend struct mbgate::StateReader;
  std::list<SettingsSnapshot> snapshots_;  // each has a stable address
};

}  // namespace mbgate::gateway
