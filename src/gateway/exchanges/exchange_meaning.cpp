// SPDX-License-Identifier: Apache-2.0
// What becomes of the meaning of an open request by other settings.
#include <algorithm>

#include "gateway/exchanges/exchange.hpp"
#include "gateway/settings/settings_snapshot.hpp"

namespace mbgate::gateway {
namespace {

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
                   resolved->route.address_of(unit) != part.job->transactions.front().unit;
}

// Its registers lie elsewhere in the device, or its values are in another order.
bool is_read_otherwise(const routing::Route& route, const routing::Route& before) {
  return route.word_order != before.word_order || route.windows != before.windows;
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
  if (resolved != nullptr && is_read_otherwise(resolved->route, exchange.route->route)) {
    return true;
  }
  return part.job->is_broadcast()
             ? has_other_devices(old, next, part.bus)
             : is_other_device(old, next, part.bus, part.job->transactions.front().unit);
}

}  // namespace mbgate::gateway
