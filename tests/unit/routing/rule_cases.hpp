// SPDX-License-Identifier: Apache-2.0
// Random lists of access rules, each with a request: few of everything, so that rules often match.
#pragma once

#include <array>
#include <random>
#include <string>
#include <vector>

#include "routing/access_rules.hpp"

namespace mbgate::test {

using modbus::Table;
using modbus::TableRange;
using routing::AccessQuestion;
using routing::AccessRule;
using routing::ClientAddress;
using routing::ClientRole;
using routing::RuleAccess;
using routing::StopIn;
using routing::TouchedRegisters;

inline constexpr std::uint16_t kRuleRegisters = 16;  // of a table, in this test
inline constexpr std::size_t kDevices = 3;
inline constexpr std::array kTablesThere{Table::coils, Table::discrete_inputs,
                                         Table::holding_registers, Table::input_registers};
inline constexpr std::array<std::uint8_t, 6> kFunctionsThere{1, 3, 6, 16, 22, 23};
inline const std::array<std::string, 3> kRoles{"", "operator", "engineer"};

/// The same as profiles.
inline std::vector<drive::Device> known_devices() {
  std::vector<drive::Device> devices(kDevices);
  for (std::size_t at = 0; at < 2; ++at) {
    auto& profile = devices[at].profile;
    profile.values.add({Table::holding_registers, 2, 2, true});
    profile.values.add({Table::holding_registers, 6, 4, false});
    profile.communication = {{Table::holding_registers, 12, 2}};
    profile.stops = {{.address = 11}};
  }
  devices[1].profile.input_as_holding = true;
  return devices;
}

class Dice {
 public:
  explicit Dice(std::uint64_t seed) : engine_(seed) {}
  std::size_t below(std::size_t end) { return engine_() % end; }
  bool one_in(std::size_t n) { return below(n) == 0; }
  template <typename List>
  auto one_of(const List& list) {
    return list[below(list.size())];
  }

 private:
  std::mt19937_64 engine_;
};

struct Case {
  std::vector<AccessRule> rules;
  ClientAddress address;
  ClientRole role;
  std::vector<TouchedRegisters> touched;
  std::uint8_t unit = 0;
  routing::UnitSet reached;
  std::uint8_t function = 0;
  bool is_read = false;
  std::uint32_t listener = 0;

  [[nodiscard]] AccessQuestion question() const {
    AccessQuestion asked{address, &role, routing::ListenerId{listener}};
    asked.unit = unit;
    asked.reached = reached;
    asked.function = function;
    asked.is_read = is_read;
    asked.touched = touched;
    return asked;
  }
};

inline std::vector<std::string> some_roles(Dice& dice) {
  std::vector<std::string> roles;
  for (const std::string& role : kRoles) {
    if (dice.one_in(3)) {
      roles.push_back(role);
    }
  }
  return roles;
}

inline routing::ClientGroup some_group(Dice& dice) {
  constexpr std::array<std::string_view, 6> kNetworks{"10.0.0.0/24", "10.0.0.4/30", "10.0.0.5",
                                                      "10.0.0.0/8",  "fd00::/64",   "10.0.0.6/31"};
  routing::ClientGroup group;
  while (dice.one_in(2)) {
    group.addresses.push_back(*routing::Network::parse(dice.one_of(kNetworks)));
  }
  if (group.addresses.empty() || dice.one_in(4)) {
    group.roles = some_roles(dice);
  }
  return group;
}

inline routing::RegisterSet some_registers(Dice& dice) {
  routing::RegisterSet set;
  while (!dice.one_in(3)) {
    const auto first = static_cast<std::uint16_t>(dice.below(kRuleRegisters));
    const auto last = static_cast<std::uint16_t>(first + dice.below(kRuleRegisters - first));
    set.spans.push_back(
        {dice.one_in(2) ? Table::holding_registers : dice.one_of(kTablesThere), first, last});
  }
  set.motion_commands = dice.one_in(4);
  set.communication_registers = dice.one_in(4);
  set.values = dice.one_in(4);
  set.stops = dice.one_in(4);
  return set;
}

inline void add_target(Dice& dice, AccessRule& rule) {
  for (std::size_t device = 0; dice.one_in(3) && device < kDevices; ++device) {
    if (dice.one_in(2)) {
      rule.devices.push_back(device);
    }
  }
  if (dice.one_in(2)) {
    rule.registers = some_registers(dice);
  }
}

inline AccessRule some_rule(Dice& dice) {
  AccessRule rule;
  rule.permits = dice.one_in(2);
  while (dice.one_in(3)) {
    rule.clients.push_back(some_group(dice));
  }
  rule.any_role = dice.one_in(3);
  if (!rule.any_role && dice.one_in(4)) {
    rule.roles = some_roles(dice);
  }
  if (dice.one_in(4)) {
    rule.listeners.push_back(routing::ListenerId{static_cast<std::uint32_t>(dice.below(2))});
  }
  if (dice.one_in(4)) {
    rule.units.emplace();
    for (std::size_t unit = 0; unit < 4; ++unit) {
      rule.units->set(unit, dice.one_in(2));
    }
  }
  if (dice.one_in(4)) {
    rule.functions.emplace();
    for (const auto function : kFunctionsThere) {
      rule.functions->set(function, dice.one_in(2));
    }
  }
  rule.access = dice.one_of(
      std::array{RuleAccess::both, RuleAccess::both, RuleAccess::read, RuleAccess::write});
  add_target(dice, rule);
  return rule;
}

inline Case some_case(Dice& dice, const std::vector<drive::Device>& devices) {
  constexpr std::array<std::string_view, 5> kClients{"10.0.0.5", "10.0.0.6", "10.0.1.1", "11.0.0.1",
                                                     "fd00::5"};
  Case made;
  for (std::size_t rules = dice.below(6); rules > 0; --rules) {
    made.rules.push_back(some_rule(dice));
  }
  made.address = *ClientAddress::parse(dice.one_of(kClients));
  if (!dice.one_in(2)) {
    made.role = {ClientRole::Kind::named, dice.one_of(kRoles)};
  } else if (dice.one_in(8)) {
    made.role = {ClientRole::Kind::unreadable};
  }
  made.unit = static_cast<std::uint8_t>(dice.below(4));
  made.reached.set(made.unit);
  while (dice.one_in(4)) {
    made.reached.set(dice.below(4));
  }
  made.function = dice.one_of(kFunctionsThere);
  made.is_read = dice.one_in(2);
  made.listener = static_cast<std::uint32_t>(dice.below(2));
  for (std::size_t count = 1 + (dice.one_in(4) ? dice.below(3) : 0); count > 0; --count) {
    TouchedRegisters touched;
    if (!dice.one_in(4)) {
      touched.number = dice.below(kDevices);
      touched.device = &devices[*touched.number];
    }
    if (!dice.one_in(8)) {
      const auto first = static_cast<std::uint16_t>(dice.below(kRuleRegisters));
      touched.range =
          TableRange{dice.one_in(2) ? Table::holding_registers : dice.one_of(kTablesThere), first,
                     static_cast<std::uint16_t>(
                         1 + dice.below(std::min<std::size_t>(4, kRuleRegisters - first)))};
    }
    if (touched.number && touched.range && !made.is_read && dice.one_in(4)) {
      touched.stop = dice.one_in(2) ? StopIn::all : StopIn::some;
    }
    made.touched.push_back(touched);
  }
  return made;
}

}  // namespace mbgate::test
