// SPDX-License-Identifier: Apache-2.0
// What becomes of the meaning of an open request by other settings.
#include <algorithm>

#include "gateway/exchanges/exchange.hpp"
#include "gateway/settings/unit_meaning.hpp"

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
  if (part.job->is_broadcast()) {
    return has_other_devices(old, next, part.bus);
  }
  const bool other_order =
      resolved != nullptr && resolved->route.word_order != exchange.route->route.word_order;
  return other_order ||
         is_other_device(old, next, part.bus, part.job->transactions.front().address);
}

}  // namespace mbgate::gateway
