// SPDX-License-Identifier: Apache-2.0
#include "gateway/settings/device_index.hpp"

#include <algorithm>
#include <iterator>

namespace mbgate::gateway {

DeviceIndex::DeviceIndex(std::span<const drive::Device> devices, std::size_t buses)
    : devices_(devices), buses_(buses) {
  for (std::size_t place = 0; place < devices.size(); ++place) {
    if (devices[place].is_gone()) {
      continue;
    }
    OnBus& bus = buses_[static_cast<std::size_t>(devices[place].bus)];
    for (std::size_t address = 0; address < kAddresses; ++address) {
      if (devices[place].stands_for(static_cast<std::uint8_t>(address))) {
        bus.by_address.at(address) = place;
      }
    }
    bus.all.push_back(place);
  }
}

std::optional<std::size_t> DeviceIndex::at(drive::BusId bus, std::uint8_t address) const {
  return buses_[static_cast<std::size_t>(bus)].by_address.at(address);
}

DevicePlaces DeviceIndex::reached_by(const routing::PlannedTransaction& transaction) const {
  if (transaction.broadcast) {
    return buses_[static_cast<std::size_t>(transaction.bus)].all;
  }
  const auto place = at(transaction.bus, transaction.address);
  return place ? DevicePlaces{*place} : DevicePlaces{};
}

DevicePlaces DeviceIndex::addressed_by(const routing::PlannedTransaction& transaction) const {
  DevicePlaces places = reached_by(transaction);
  if (transaction.broadcast) {
    const auto deaf = std::ranges::remove_if(places, [&](std::size_t place) {
      return !devices_[place].is_addressed_by(transaction.address, transaction.broadcast);
    });
    places.erase(deaf.begin(), deaf.end());
  }
  return places;
}

}  // namespace mbgate::gateway
