// SPDX-License-Identifier: Apache-2.0
// Which devices of the settings a transaction is for, in one look-up.
#pragma once

#include <array>
#include <boost/container/small_vector.hpp>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "drive/device.hpp"
#include "routing/plan.hpp"

namespace mbgate::gateway {

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
  [[nodiscard]] DevicePlaces reached_by(const routing::PlannedTransaction& transaction) const;
  /// Those that it is meant for: of a broadcast the ones that hear its form.
  [[nodiscard]] DevicePlaces addressed_by(const routing::PlannedTransaction& transaction) const;

 private:
  struct OnBus {
    std::array<std::optional<std::size_t>, kAddresses> by_address;
    DevicePlaces all;
  };

  std::span<const drive::Device> devices_;
  std::vector<OnBus> buses_;
};

}  // namespace mbgate::gateway
