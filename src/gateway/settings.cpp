// SPDX-License-Identifier: Apache-2.0
#include "gateway/settings.hpp"

#include <iterator>
#include <numeric>

namespace mbgate::gateway {
namespace {

std::vector<std::size_t> all(std::size_t count) {
  std::vector<std::size_t> numbers(count);
  std::iota(numbers.begin(), numbers.end(), std::size_t{0});
  return numbers;
}

}  // namespace

std::string Settings::device_name(BusId bus, std::uint8_t address) const {
  const auto device = std::ranges::find_if(
      devices, [&](const drive::Device& it) { return it.bus == bus && it.address == address; });
  return device == devices.end() ? std::string() : device->name;
}

std::vector<drive::Device> Settings::devices_on(BusId bus) const {
  std::vector<drive::Device> found;
  std::ranges::copy_if(devices, std::back_inserter(found),
                       [bus](const drive::Device& device) { return device.bus == bus; });
  return found;
}

std::vector<BusId> Settings::written_buses() const {
  std::vector<BusId> written;
  for (const std::size_t number : written_order ? written_order->buses : all(buses.size())) {
    written.push_back(BusId{static_cast<std::uint32_t>(number)});
  }
  return written;
}

std::vector<Settings::WrittenDevice> Settings::written_devices() const {
  const std::vector<BusId> order = written_buses();
  std::vector<WrittenDevice> written;
  for (const std::size_t number : written_order ? written_order->devices : all(devices.size())) {
    const auto bus = std::ranges::find(order, devices[number].bus);
    written.push_back({&devices[number], static_cast<std::size_t>(bus - order.begin())});
  }
  return written;
}

}  // namespace mbgate::gateway
