// SPDX-License-Identifier: Apache-2.0
// Settings with what is derived from them. A request keeps the snapshot that it was planned with,
// so a reload takes nothing away from it.
#pragma once

#include <array>
#include <boost/container/small_vector.hpp>
#include <limits>
#include <list>
#include <optional>
#include <span>
#include <vector>

#include "drive/device.hpp"
#include "gateway/client.hpp"
#include "gateway/settings.hpp"
#include "routing/plan.hpp"
#include "routing/route_table.hpp"

namespace mbgate::gateway {

// Which devices of the settings a transaction is for, in one look-up.

/// Places in Settings::devices.
using DevicePlaces = boost::container::small_vector<std::size_t, 4>;

class DeviceIndex {
 public:
  static constexpr std::size_t kAddresses = std::numeric_limits<std::uint8_t>::max() + 1;

  DeviceIndex(std::span<const drive::Device> devices, std::size_t buses);

  /// Nothing: no device is configured there.
  [[nodiscard]] std::optional<std::size_t> at(drive::BusId bus, std::uint8_t address) const;
  /// Those that a transaction may change: the one at its address or, for a broadcast, which any
  /// device may obey, all of the bus.
  [[nodiscard]] DevicePlaces reached_by(const drive::Transaction& transaction) const;
  /// Those that it is meant for: of a broadcast the ones that hear its form.
  [[nodiscard]] DevicePlaces addressed_by(const drive::Transaction& transaction) const;

 private:
  using ByAddress = std::array<std::optional<std::size_t>, kAddresses>;

  std::span<const drive::Device> devices_;
  std::vector<ByAddress> buses_;
};

struct SettingsSnapshot {
  explicit SettingsSnapshot(Settings given);
  SettingsSnapshot(const SettingsSnapshot&) = delete;  // its parts refer to each other
  SettingsSnapshot& operator=(const SettingsSnapshot&) = delete;

  /// The rules of a device, if there are any.
  [[nodiscard]] const DeviceGuard& guard(std::size_t device) const;

  Settings settings;
  routing::RouteTable routes;
  DeviceIndex devices;
  std::size_t exchanges = 0;  ///< that refer to it
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
    snapshots_.remove_if(
        [this](const SettingsSnapshot& it) { return it.exchanges == 0 && &it != &in_force(); });
  }

 private:
  std::list<SettingsSnapshot> snapshots_;  // each has a stable address
};

// What a request means is said by the settings: to which device its unit leads, and what is
// understood there. Other settings may make something else of the same request.

/// Where the device that was at `place` is among the next ones; nothing: it is gone. Port and
/// address decide, whatever the names are.
[[nodiscard]] std::optional<std::size_t> place_of_same_drive(const Settings& old, std::size_t place,
                                                             const Settings& next);
/// Does a request that was made for the device at the address mean something else there now? A
/// device that appears where none was counts, and one that is gone.
[[nodiscard]] bool is_other_device(const SettingsSnapshot& old, const SettingsSnapshot& next,
                                   BusId bus, std::uint8_t address);

/// The same of any device of the bus.
[[nodiscard]] bool has_other_devices(const SettingsSnapshot& old, const SettingsSnapshot& next,
                                     BusId bus);

/// A unit identifier of the clients of a listener.
using UnitOfListener = std::pair<ListenerId, std::uint8_t>;

/// Does the unit lead to another device or to other registers, is it understood otherwise, or does
/// it no longer lead anywhere? A bus on another port has other devices. The listener is one of
/// `old`. `on_bus`: of a broadcast only what becomes of it there.
[[nodiscard]] bool unit_means_otherwise(const UnitOfListener& place, const SettingsSnapshot& old,
                                        const SettingsSnapshot& next,
                                        std::optional<BusId> on_bus = std::nullopt);

// Listeners, buses and devices are numbered once, by name. A number keeps its meaning, so that
// nothing stored under it can mean another thing after a reload.

/// The settings `read`, with the numbers of those in force: the same name has the same number, what
/// is new gets an unused one, and what was removed keeps an empty entry (`is_gone`).
[[nodiscard]] Settings numbered_after(const Settings& in_force, Settings read);

/// Does the bus keep the same line?
[[nodiscard]] bool keeps_line(const Settings& old, const Settings& next, BusId bus);

}  // namespace mbgate::gateway
