// SPDX-License-Identifier: Apache-2.0
// What becomes of the meaning of an open request by other settings.
#include <algorithm>

#include "gateway/exchanges/exchange.hpp"

namespace mbgate::gateway {
namespace {

// Does a request that was made for the old address mean something else there now? A device that
// appears where none was counts, and one that is gone.
bool is_other_device(const drive::Device* old, const drive::Device* next) {
  if (old == nullptr || next == nullptr) {
    return old != next;
  }
  return old->name != next->name || !next->understands_as(*old);
}

const drive::Device* device_at(const SettingsSnapshot& snapshot, BusId bus, std::uint8_t address) {
  const auto place = snapshot.devices.at(bus, address);
  return place ? &snapshot.settings.devices[*place] : nullptr;
}

// Its unit is another device's now, or nobody's.
bool leads_elsewhere(const routing::ResolvedRoute* resolved, const Exchange& exchange,
                     const Exchange::Part& part, const Settings& next) {
  const std::uint8_t unit = exchange.header.unit;
  if (resolved == nullptr || next.status_unit == unit ||
      resolved->is_broadcast() != part.job->is_broadcast()) {
    return true;
  }
  return resolved->is_broadcast()
             ? std::ranges::find(resolved->route.buses, part.bus) == resolved->route.buses.end()
             : resolved->route.buses.front() != part.bus ||
                   resolved->route.address_of(unit) != part.job->transactions.front().address;
}

}  // namespace

bool means_otherwise(const Exchange& exchange, const Exchange::Part& part,
                     const SettingsSnapshot& old, const SettingsSnapshot& next) {
  const bool listens = !exchange.client_gone && !next.settings.listener(exchange.listener).is_gone;
  const routing::ResolvedRoute* resolved =
      listens ? next.routes.find(exchange.listener, exchange.header.unit) : nullptr;
  if (listens && leads_elsewhere(resolved, exchange, part, next.settings)) {
    return true;
  }
  const auto is_other = [&](std::uint8_t address) {
    return is_other_device(device_at(old, part.bus, address), device_at(next, part.bus, address));
  };
  if (part.job->is_broadcast()) {
    for (std::size_t address = 0; address < DeviceIndex::kAddresses; ++address) {
      if (is_other(static_cast<std::uint8_t>(address))) {
        return true;
      }
    }
    return false;
  }
  const bool other_order =
      resolved != nullptr && resolved->route.word_order != exchange.route->route.word_order;
  return other_order || is_other(part.job->transactions.front().address);
}

}  // namespace mbgate::gateway
