// SPDX-License-Identifier: Apache-2.0
// The plant with stops, and access rules for it.
#pragma once

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {

using routing::AccessRule;

/// The answer to a write_request(2) that is denied.
inline constexpr auto kDenied = "00 02 00 00 00 03 01 86 01";

inline AccessRule rule(bool permits, std::string name) {
  AccessRule made;
  made.permits = permits;
  made.name = std::move(name);
  made.place = "mbgate.toml:7";
  return made;
}

inline AccessRule rule_for(std::string_view network, bool permits = true) {
  AccessRule made = rule(permits, "panels");
  made.clients = {{"panels", {*routing::Network::parse(network)}, {}}};
  return made;
}

inline AccessRule reading() {
  AccessRule made = rule(true, "reading");
  made.access = routing::RuleAccess::read;
  return made;
}

inline Settings plant_with(std::vector<AccessRule> rules) {
  Settings settings = stop_plant(16);
  settings.rules = std::move(rules);
  return settings;
}

}  // namespace mbgate::test
