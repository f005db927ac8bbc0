// SPDX-License-Identifier: Apache-2.0
// Which rule decides.
#include "routing/access_rules.hpp"

#include <gtest/gtest.h>

#include "device_rig.hpp"

namespace mbgate::test {
namespace {

using routing::AccessRule;
using routing::ClientRole;
using routing::RegisterSpan;
using routing::StopIn;
using routing::TouchedRegisters;

const ClientRole kPlain;
const ClientRole kNull{ClientRole::Kind::named, ""};
const ClientRole kOperator{ClientRole::Kind::named, "operator"};
const ClientRole kUnreadable{ClientRole::Kind::unreadable};

routing::ClientGroup panels() { return {"panels", {*routing::Network::parse("10.0.0.0/24")}, {}}; }
routing::ClientGroup operators() { return {"operators", {}, {"operator"}}; }
AccessRule deny() {
  AccessRule rule;
  rule.permits = false;
  return rule;
}

struct Asked {
  std::string_view from = "10.0.0.5";
  const ClientRole* role = &kPlain;
  std::uint32_t listener = 0;
  std::uint8_t unit = 1;
  std::uint8_t function = 0x06;
  bool is_read = false;
  std::vector<TouchedRegisters> touched{
      {.range = modbus::TableRange{Table::holding_registers, 124, 2}}};
  std::vector<std::uint8_t> reached{};
};

/// The place of the rule that decides, and "+" or "-"; "none" if none does.
std::string decided(const std::vector<AccessRule>& rules, const Asked& asked) {
  const auto address = *routing::ClientAddress::parse(asked.from);
  routing::AccessQuestion question{address, asked.role, routing::ListenerId{asked.listener}};
  question.unit = asked.unit;
  question.reached.set(asked.unit);
  for (const auto unit : asked.reached) {
    question.reached.set(unit);
  }
  question.function = asked.function;
  question.is_read = asked.is_read;
  question.touched = asked.touched;
  const auto decision = decide(rules, question);
  return decision.rule == nullptr
             ? (decision.permitted ? "none+" : "none-")
             : std::to_string(decision.rule - rules.data()) + (decision.permitted ? "+" : "-");
}

TEST(AccessRules, WithoutAnyEverythingIsPermitted) { EXPECT_EQ(decided({}, {}), "none+"); }

TEST(AccessRules, TheFirstThatMatchesDecidesAndWhatNoneMatchesIsDenied) {
  AccessRule reads;
  reads.access = routing::RuleAccess::read;
  EXPECT_EQ(decided({reads}, {}), "none-");
  EXPECT_EQ(decided({reads, deny(), {}}, {}), "1-");
  EXPECT_EQ(decided({reads, deny()}, {.function = 3, .is_read = true}), "0+");
}

TEST(AccessRules, MatchGroupsByAddressListenerUnitAndFunction) {
  AccessRule rule;
  rule.clients = {panels()};
  EXPECT_EQ(decided({rule}, {}), "0+");
  EXPECT_EQ(decided({rule}, {.from = "10.0.1.5"}), "none-");
  rule.listeners = {routing::ListenerId{1}};
  EXPECT_EQ(decided({rule}, {}), "none-");
  EXPECT_EQ(decided({rule}, {.listener = 1}), "0+");
  rule.units.emplace().set(7);
  EXPECT_EQ(decided({rule}, {.listener = 1}), "none-");
  EXPECT_EQ(decided({rule}, {.listener = 1, .unit = 7}), "0+");
  rule.functions.emplace().set(16);
  EXPECT_EQ(decided({rule}, {.listener = 1, .unit = 7}), "none-");
  EXPECT_EQ(decided({rule}, {.listener = 1, .unit = 7, .function = 16}), "0+");
}

TEST(AccessRules, MatchARoleOnlyIfTheyNameIt) {
  AccessRule named;
  named.roles = {"operator"};
  AccessRule unnamed;
  AccessRule any;
  any.any_role = true;
  AccessRule null;
  null.roles = {""};
  AccessRule group;
  group.clients = {operators()};
  struct Row {
    const ClientRole* role;
    std::vector<std::string> by;
  };
  for (const auto& [role, by] :
       {Row{&kPlain, {"none-", "0+", "0+", "none-", "none-"}},
        Row{&kNull, {"none-", "none-", "0+", "0+", "none-"}},
        Row{&kOperator, {"0+", "none-", "0+", "none-", "0+"}},
        Row{&kUnreadable, {"none-", "none-", "none-", "none-", "none-"}}}) {
    std::size_t at = 0;
    for (const AccessRule& rule : {named, unnamed, any, null, group}) {
      EXPECT_EQ(decided({rule}, {.role = role}), by[at]) << role->name << at;
      ++at;
    }
  }
}

TEST(AccessRules, PermitOnlyWhatLiesInTheirRegistersWholeAndDenyWhatTouchesThem) {
  AccessRule permit;
  permit.registers.spans = {{Table::holding_registers, 100, 124}};
  AccessRule deny_it = deny();
  deny_it.registers = permit.registers;
  EXPECT_EQ(decided({permit}, {}), "none-");
  EXPECT_EQ(decided({deny_it, {}}, {}), "0-");
  permit.registers.spans.push_back({Table::holding_registers, 125, 125});
  EXPECT_EQ(decided({permit}, {}), "0+");
  permit.registers.spans[1].table = Table::coils;
  EXPECT_EQ(decided({permit}, {}), "none-");
  deny_it.registers.spans[0].last = 123;
  EXPECT_EQ(decided({deny_it, {}}, {}), "1+");
}

TEST(AccessRules, KnowNothingOfTheRegistersOfAFunctionThatNamesNone) {
  AccessRule permit;
  permit.registers.spans = {RegisterSpan{}};
  AccessRule deny_it = deny();
  deny_it.registers = permit.registers;
  EXPECT_EQ(decided({permit}, {.function = 8, .touched = {{}}}), "none-");
  EXPECT_EQ(decided({deny_it, {}}, {.function = 8, .touched = {{}}}), "1+");
}

TEST(AccessRules, TakeInputRegistersForHoldingOnesWhereTheyAreTheSame) {
  drive::Device device = small_drive();
  const TouchedRegisters input{0, &device, modbus::TableRange{Table::input_registers, 124, 1}};
  const TouchedRegisters holding{0, &device, modbus::TableRange{Table::holding_registers, 9, 1}};
  AccessRule rule = deny();
  rule.registers.spans = {{Table::holding_registers, 124, 124}, {Table::input_registers, 9, 9}};
  EXPECT_EQ(decided({rule, {}}, {.touched = {input}}), "1+");
  EXPECT_EQ(decided({rule, {}}, {.touched = {holding}}), "1+");
  device.profile.input_as_holding = true;
  EXPECT_EQ(decided({rule, {}}, {.touched = {input}}), "0-");
  EXPECT_EQ(decided({rule, {}}, {.touched = {holding}}), "0-");
}

TEST(AccessRules, TakeNamesFromTheProfileOfTheDevice) {
  drive::Device device = small_drive();
  device.profile.stops = {{.address = 40, .value = 0}};
  device.profile.communication = {{Table::holding_registers, 50, 3}};
  device.profile.position_opcodes = drive::PositionOpcodes{60, {0x98}, 70};
  const auto by = [&](bool routing::RegisterSet::*name, std::uint16_t first, std::uint16_t count) {
    AccessRule rule;
    rule.registers.*name = true;
    const TouchedRegisters touched{0, &device,
                                   modbus::TableRange{Table::holding_registers, first, count}};
    return decided({rule}, {.touched = {touched}});
  };
  using Set = routing::RegisterSet;
  for (const auto& [first, count] :
       {std::pair<std::uint16_t, std::uint16_t>{20, 2}, {40, 1}, {60, 1}, {70, 2}}) {
    EXPECT_EQ(by(&Set::motion_commands, first, count), "0+") << first;
    EXPECT_EQ(by(&Set::communication_registers, first, count), "none-") << first;
  }
  for (const auto& [first, count] :
       {std::pair<std::uint16_t, std::uint16_t>{10, 2}, {19, 2}, {71, 2}, {41, 1}}) {
    EXPECT_EQ(by(&Set::motion_commands, first, count), "none-") << first;
  }
  EXPECT_EQ(by(&Set::communication_registers, 50, 3), "0+");
  EXPECT_EQ(by(&Set::communication_registers, 50, 4), "none-");
  EXPECT_EQ(by(&Set::values, 4, 4), "0+");
  EXPECT_EQ(by(&Set::values, 4, 5), "none-");
  EXPECT_EQ(by(&Set::stops, 40, 1), "none-");
}

TEST(AccessRules, KnowWhatReconfiguresByWhatItWrites) {
  drive::Device device = small_drive();
  device.profile.guarded = {{{Table::holding_registers, 50, 1}, 0xFFFFFFFF, 0}};
  AccessRule rule;
  rule.registers.communication_registers = true;
  TouchedRegisters touched{0, &device, modbus::TableRange{Table::holding_registers, 50, 1}};
  EXPECT_EQ(decided({rule}, {.touched = {touched}}), "none-") << "another value, or a read";
  touched.reconfigures = true;
  EXPECT_EQ(decided({rule}, {.touched = {touched}}), "0+");
  touched.range->count = 2;
  EXPECT_EQ(decided({rule}, {.touched = {touched}}), "none-") << "and one that it does not name";
  rule.permits = false;
  EXPECT_EQ(decided({rule, {}}, {.touched = {touched}}), "0-");
}

TEST(AccessRules, KnowAStopByWhatItWrites) {
  AccessRule rule;
  rule.registers.stops = true;
  TouchedRegisters write{.range = modbus::TableRange{Table::holding_registers, 40, 1}};
  EXPECT_EQ(decided({rule}, {.touched = {write}}), "none-");
  TouchedRegisters stop = write;
  stop.stop = StopIn::all;
  EXPECT_EQ(decided({rule}, {.touched = {stop}}), "0+");
  EXPECT_EQ(decided({rule}, {.touched = {stop, write}}), "none-");
}

TEST(AccessRules, PermitAStopWithWhatIsWrittenBehindItOnlyIfThatIsNamedToo) {
  AccessRule rule;
  rule.registers.stops = true;
  const TouchedRegisters parameters{.range = modbus::TableRange{Table::holding_registers, 41, 5}};
  TouchedRegisters stop{.range = modbus::TableRange{Table::holding_registers, 40, 1},
                        .stop = StopIn::all};
  EXPECT_EQ(decided({rule}, {.touched = {stop, parameters}}), "none-");
  rule.registers.spans = {{Table::holding_registers, 41, 44}};
  EXPECT_EQ(decided({rule}, {.touched = {stop, parameters}}), "none-");
  rule.registers.spans[0].last = 45;
  EXPECT_EQ(decided({rule}, {.touched = {stop, parameters}}), "0+");
  stop.stop = StopIn::some;
  EXPECT_EQ(decided({rule}, {.touched = {stop, parameters}}), "none-");
  rule.registers.spans[0].first = 40;
  EXPECT_EQ(decided({rule}, {.touched = {stop, parameters}}), "0+");
}

TEST(AccessRules, PermitAStopOfSeveralRegisters) {
  AccessRule rule;
  rule.registers.stops = true;
  const TouchedRegisters stop{.range = modbus::TableRange{Table::holding_registers, 40, 3},
                              .stop = StopIn::all};
  EXPECT_EQ(decided({rule}, {.touched = {stop}}), "0+");
}

TEST(AccessRules, DenyWhateverHoldsAStop) {
  AccessRule rule = deny();
  rule.registers.stops = true;
  TouchedRegisters write{.range = modbus::TableRange{Table::holding_registers, 40, 6}};
  EXPECT_EQ(decided({rule, {}}, {.touched = {write}}), "1+");
  for (const StopIn stop : {StopIn::all, StopIn::some}) {
    write.stop = stop;
    EXPECT_EQ(decided({rule, {}}, {.touched = {write}}), "0-");
  }
}

TEST(AccessRules, DenyABroadcastByAnyUnitAndAnyDeviceThatItIsFor) {
  AccessRule unit = deny();
  unit.units.emplace().set(11);
  const Asked broadcast{.unit = 0, .touched = {{.number = 0}, {.number = 1}}, .reached = {11, 12}};
  EXPECT_EQ(decided({unit, {}}, broadcast), "0-");
  unit.permits = true;
  EXPECT_EQ(decided({unit}, broadcast), "none-");
  AccessRule device = deny();
  device.devices = {1};
  EXPECT_EQ(decided({device, {}}, broadcast), "0-");
  device.permits = true;
  EXPECT_EQ(decided({device}, broadcast), "none-");
  device.devices = {1, 0};
  EXPECT_EQ(decided({device}, broadcast), "0+");
}

TEST(AccessRules, PermitWhatMayBeMatchedAsLongAsItIsNotKnown) {
  AccessRule narrow = deny();
  narrow.units.emplace().set(3);
  AccessRule some;
  some.clients = {panels()};
  some.registers.values = true;
  const auto may = [&](std::string_view from, const ClientRole* role,
                       const std::vector<AccessRule>& rules) {
    const auto address = *routing::ClientAddress::parse(from);
    return decide(rules, {address, role, routing::ListenerId{0}}).permitted;
  };
  EXPECT_TRUE(may("10.0.0.5", &kPlain, {narrow, some}));
  EXPECT_FALSE(may("10.0.1.5", &kPlain, {narrow, some}));
  EXPECT_FALSE(may("10.0.0.5", &kPlain, {deny(), some}));
  EXPECT_FALSE(may("10.0.0.5", nullptr, {narrow, some}));  // a role, and none is named
  some.any_role = true;
  EXPECT_TRUE(may("10.0.0.5", nullptr, {narrow, some}));
}

TEST(AccessRules, AreHiddenByAnEarlierOneThatMatchesAllOfIt) {
  AccessRule all;
  AccessRule some;
  some.clients = {panels()};
  some.units.emplace().set(3);
  some.registers.spans = {{Table::holding_registers, 5, 6}};
  EXPECT_TRUE(hides(all, some));
  EXPECT_FALSE(hides(some, all));
  EXPECT_TRUE(hides(some, some));
  AccessRule denied = some;
  denied.permits = false;
  EXPECT_FALSE(hides(some, denied));  // it may touch others too
  some.roles = {"operator"};
  EXPECT_FALSE(hides(all, some));
  all.any_role = true;
  EXPECT_TRUE(hides(all, some));
}

}  // namespace
}  // namespace mbgate::test
