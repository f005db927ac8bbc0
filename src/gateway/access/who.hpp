// SPDX-License-Identifier: Apache-2.0
// What would become of a request of this client, and what decides: `mbgated --check --who`. It asks
// the parts that the gateway itself asks, in their order.
#pragma once

#include <cstdint>
#include <string>

#include "gateway/client.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "modbus/pdu.hpp"

namespace mbgate::gateway {

struct WhoAnswer {
  bool permitted = false;
  /// `permitted by rule "panel" (mbgate.toml:12)`, `denied by read_only of listener plant:
  /// exception 01`: the first that denies it, or the rule that permits it.
  std::string text;
};

[[nodiscard]] WhoAnswer who_may(const SettingsSnapshot& settings, const ClientInfo& client,
                                std::uint8_t unit, const modbus::Pdu& request);

}  // namespace mbgate::gateway
