// SPDX-License-Identifier: Apache-2.0
// Access rules in the machine: who is let in, what is denied, what is over a rate.
#include <gmock/gmock.h>

#include "unit/gateway/access/access_plant.hpp"
#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using routing::ClientRole;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

TEST(AccessInTheMachine, WhatNoRulePermitsGets01AndNothingIsSent) {
  MachineRig rig(plant_with({reading()}));
  rig.connect(1);
  rig.receive(1, read_request(1) + write_request(2));
  rig.respond("01 03 02 00 01");
  EXPECT_THAT(rig.take_sent(1), ElementsAre(kDenied, kOne));
  EXPECT_THAT(take_requests(rig), ElementsAre(kRead1));
  EXPECT_THAT(
      rig.events,
      ElementsAre("listener plant: client 192.0.2.1: function 6 at unit 1, holding register 0 "
                  "= 1, denied by the access rules: no rule permits it"));
}

TEST(AccessInTheMachine, AListenerIsOpenToAllIfNeitherItsListNorARuleSaysWhoMay) {
  Settings settings = stop_plant();
  gateway::ListenerSettings& listener = settings.listeners[0];
  EXPECT_TRUE(settings.is_open_to_all(listener));
  listener.allow = {*routing::Network::parse("192.0.2.0/24")};
  EXPECT_FALSE(settings.is_open_to_all(listener));
  listener.allow.clear();
  settings.rules = {reading()};
  EXPECT_FALSE(settings.is_open_to_all(listener));
}

TEST(AccessInTheMachine, TheJournalIsToldOnceAMinuteForEachClientAndOfWhichRule) {
  MachineRig rig(plant_with({rule(false, "locked"), rule(true, "")}));
  rig.connect(1, "192.0.2.1");  // could be permitted nothing: closed
  EXPECT_TRUE(rig.closed.contains(1));
  AccessRule writes = rule(false, "locked");
  writes.access = routing::RuleAccess::write;
  MachineRig other(plant_with({writes, rule(true, "")}));
  other.connect(1);
  other.connect(2, "192.0.2.2");
  other.receive(1, write_request(2) + write_request(2) + write_request(2));
  other.receive(2, write_request(2));
  EXPECT_THAT(
      other.events,
      ElementsAre("listener plant: client 192.0.2.1: function 6 at unit 1, holding register 0 "
                  "= 1, denied by rule \"locked\" (mbgate.toml:7)",
                  "listener plant: client 192.0.2.2: function 6 at unit 1, holding register 0 "
                  "= 1, denied by rule \"locked\" (mbgate.toml:7)"));
  other.events.clear();
  other.advance(60s);
  other.receive(1, write_request(2));
  EXPECT_THAT(
      other.events,
      ElementsAre("listener plant: client 192.0.2.1: function 6 at unit 1, holding register 0 "
                  "= 1, denied by rule \"locked\" (mbgate.toml:7); 2 more were denied since the "
                  "last report for this client"));
}

// Registers of which some values change a drive's communication count as such only for these.
TEST(AccessInTheMachine, CommunicationIsDeniedByTheValuesThatChangeIt) {
  AccessRule locked = rule(false, "locked");
  locked.registers.communication_registers = true;
  Settings settings = plant_with({locked, rule(true, "")});
  settings.devices[0].allow_reconfigure = true;
  settings.devices[0].profile.guarded = {{{modbus::Table::holding_registers, 0x32, 1}, 0xFFFF, 0}};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 01 06 0032 0000 0002 0000 0006 01 06 0032 0001");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 86 01"));
  EXPECT_THAT(take_requests(rig), ElementsAre("01 06 00 32 00 01"));
}

TEST(AccessInTheMachine, AStopIsDeniedByItsRegister) {
  AccessRule locked = rule(false, "locked");
  locked.registers.spans = {{modbus::Table::holding_registers, 0x7C, 0x7C}};
  MachineRig rig(plant_with({locked, rule(true, "")}));
  rig.connect(1);
  rig.receive(1, stop_request(2));
  EXPECT_THAT(rig.take_sent(1), ElementsAre(kDenied));
  EXPECT_THAT(take_requests(rig), IsEmpty());
}

TEST(AccessInTheMachine, AnAddressThatNoRulePermitsAnythingIsClosedBeforeAByteIsRead) {
  MachineRig rig(plant_with({rule_for("192.0.2.0/28")}));
  rig.connect(1, "192.0.2.1");
  rig.connect(2, "192.0.2.99");
  EXPECT_FALSE(rig.closed.contains(1));
  EXPECT_TRUE(rig.closed.contains(2));
  EXPECT_THAT(rig.events, ElementsAre("listener plant: client 192.0.2.99 refused: no access rule "
                                      "permits its address anything"));
}

TEST(AccessInTheMachine, OtherRulesApplyAtOnceToOpenConnections) {
  MachineRig rig(plant_with({rule(true, "")}));
  rig.connect(1, "192.0.2.1");
  rig.connect(2, "192.0.2.99");
  AccessRule reads = reading();
  reads.clients = rule_for("192.0.2.0/28").clients;
  rig.reload(plant_with({reads}));
  EXPECT_FALSE(rig.closed.contains(1));
  EXPECT_TRUE(rig.closed.contains(2));
  rig.receive(1, write_request(2));
  EXPECT_THAT(rig.take_sent(1), ElementsAre(kDenied));
  rig.reload(plant_with({}));
  rig.receive(1, write_request(3));
  EXPECT_THAT(take_requests(rig), ElementsAre(kWrite1));
}

TEST(AccessInTheMachine, OverItsRateAClientIsNotToldOfTheGatewayEither) {
  AccessRule limited = rule(true, "limited");
  limited.per_second = 1;
  MachineRig rig(plant_with({limited}));
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 FF 04 0000 0001 0002 0000 0006 FF 04 0000 0001");
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 01 00 00 00 05 FF 04 02 00 02", "00 02 00 00 00 03 FF 84 06"));
}

TEST(AccessInTheMachine, OverItsRateAClientGets06AndAStopGoesAllTheSame) {
  AccessRule limited = rule(true, "limited");
  limited.per_second = 2;
  MachineRig rig(plant_with({limited}));
  rig.connect(1, "192.0.2.1");
  rig.connect(2, "192.0.2.1");  // the same address
  rig.connect(3, "192.0.2.3");
  rig.receive(1, write_request(1));
  rig.receive(2, write_request(2));
  rig.receive(2, write_request(3));
  EXPECT_THAT(rig.take_sent(2), ElementsAre(busy(3)));
  rig.receive(3, write_request(4));
  EXPECT_THAT(rig.take_sent(3), IsEmpty());
  rig.receive(2, stop_request(5));
  for (int answers = 0; answers < 2; ++answers) {
    rig.respond(answers == 0 ? "01 06 00 00 00 01" : "01 06 00 7C 00 E1");
    rig.advance(10ms);
  }
  EXPECT_THAT(rig.take_sent(2), Contains(written(5, 1, true)));
  rig.advance(500ms);  // one more of two a second
  rig.take_transmitted();
  rig.receive(1, write_request(6) + write_request(7));
  EXPECT_THAT(rig.take_sent(1), Contains(busy(7)));
  EXPECT_THAT(take_requests(rig), ElementsAre(kWrite1));
}

TEST(AccessInTheMachine, AStopThatIsDeniedIsNoneAndNeitherWhenItIsTakenEarly) {
  AccessRule unit = rule(false, "not this one");
  unit.units.emplace().set(1);
  Settings settings = plant_with({unit, rule(true, "")});
  settings.listeners[0].pipeline = 1;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1, 2) + stop_request(2, 1) + stop_request(3, 2));
  rig.respond("02 06 00 7C 00 E1");
  rig.advance(10ms);
  rig.respond("02 03 02 00 01");
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop2, "02 03 00 00 00 01"));
  EXPECT_THAT(rig.take_sent(1), Contains(kDenied));
}

TEST(AccessInTheMachine, ReadingAndWritingAtOnceNeedsBoth) {
  AccessRule writes = rule(false, "read only here");
  writes.access = routing::RuleAccess::write;
  AccessRule reads = reading();
  reads.registers.spans = {{modbus::Table::holding_registers, 0, 9}};
  AccessRule writable = rule(true, "writing");
  writable.access = routing::RuleAccess::write;
  writable.registers.spans = {{modbus::Table::holding_registers, 20, 29}};
  const auto sent_with = [](std::vector<AccessRule> rules, std::string_view reads_at,
                            std::string_view writes_at) {
    MachineRig rig(plant_with(std::move(rules)));
    rig.connect(1);
    rig.receive(1, "0001 0000 000D 01 17 " + std::string(reads_at) + " 0001 " +
                       std::string(writes_at) + " 0001 02 0007");
    return rig.take_transmitted().size();
  };
  EXPECT_EQ(sent_with({writes, reading()}, "0001", "0014"), 0U);
  EXPECT_EQ(sent_with({reads, writable}, "0001", "0014"), 1U);
  EXPECT_EQ(sent_with({reads, writable}, "000A", "0014"), 0U);
  EXPECT_EQ(sent_with({reads, writable}, "0001", "0013"), 0U);
}

TEST(AccessInTheMachine, RegistersAreThoseOfTheDeviceBehindAWindow) {
  AccessRule locked = rule(false, "locked");
  locked.registers.spans = {{modbus::Table::holding_registers, 500, 500}};
  Settings settings = plant_with({locked, rule(true, "")});
  settings.routes[0].windows = {
      {modbus::Table::holding_registers, 0, 10, modbus::Table::holding_registers, 496}};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 01 03 0000 0004");
  EXPECT_THAT(take_requests(rig), ElementsAre("01 03 01 F0 00 04"));
  rig.respond("01 03 08 0000 0000 0000 0000");
  rig.receive(1, "0002 0000 0006 01 03 0000 0005  0003 0000 0006 01 03 01F4 0001");
  EXPECT_THAT(rig.take_sent(1), Contains("00 02 00 00 00 03 01 83 01"));
  EXPECT_THAT(take_requests(rig), IsEmpty());
}

TEST(AccessInTheMachine, ABroadcastReachesNoUnitThatIsDenied) {
  AccessRule locked = rule(false, "locked");
  locked.units.emplace().set(2);
  Settings settings = plant_with({locked, rule(true, "")});
  auto& broadcast = settings.routes.emplace_back();
  broadcast.buses = {BusId{0}};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, write_request(2, 0));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 00 86 01"));
  EXPECT_THAT(take_requests(rig), IsEmpty());
}

TEST(AccessInTheMachine, WhatIsDeniedIsNotToldWhetherItCouldBeDone) {
  AccessRule known = rule(true, "unit 1");
  known.units.emplace().set(1);
  MachineRig rig(plant_with({known}));
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 FA 03 0000 0001  0002 0000 0006 01 03 0000 0000");
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 01 00 00 00 03 FA 83 01", "00 02 00 00 00 03 01 83 03"));
}

TEST(AccessInTheMachine, TheOwnUnitHasRulesToo) {
  AccessRule own = rule(true, "watchers");
  own.units.emplace().set(255);
  own.registers.spans = {{modbus::Table::input_registers, 0, 9}};
  MachineRig rig(plant_with({own}));
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 FF 04 0000 0001  0002 0000 0006 FF 04 03E8 0001");
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 01 00 00 00 05 FF 04 02 00 02", "00 02 00 00 00 03 FF 84 01"));
}

TEST(AccessInTheMachine, ARoleDecidesAndOneThatCannotBeReadIsDeniedEverything) {
  AccessRule operators = rule(true, "operators");
  operators.roles = {"operator"};
  MachineRig rig(plant_with({operators}));
  rig.connect(1, "192.0.2.1", 0, {}, {ClientRole::Kind::named, "operator"});
  rig.connect(2, "192.0.2.1", 0, {}, {ClientRole::Kind::named, "guest"});
  rig.connect(3, "192.0.2.1", 0, {}, {ClientRole::Kind::unreadable, ""});
  rig.connect(4, "192.0.2.1");
  EXPECT_THAT(rig.closed, ElementsAre(4U));  // without a role nothing can be permitted
  for (const std::uint64_t client : {1, 2, 3}) {
    rig.receive(client, write_request(2));
  }
  EXPECT_THAT(take_requests(rig), ElementsAre(kWrite1));
  EXPECT_THAT(rig.take_sent(2), ElementsAre(kDenied));
  EXPECT_THAT(rig.take_sent(3), ElementsAre(kDenied));
  MachineRig without_rules(plant_with({}));
  without_rules.connect(3, "192.0.2.1", 0, {}, {ClientRole::Kind::unreadable, ""});
  without_rules.receive(3, write_request(2) + "0003 0000 0006 FF 04 0000 0001");
  EXPECT_THAT(without_rules.take_sent(3), ElementsAre(kDenied, "00 03 00 00 00 03 FF 84 01"));
}

TEST(AccessInTheMachine, RulesKeepTheirDevicesWhenAReloadNumbersThemAnew) {
  AccessRule second = rule(true, "axis-y");
  second.devices = {1};
  MachineRig rig(plant_with({second}));
  rig.connect(1);
  rig.receive(1, write_request(2, 1));
  EXPECT_THAT(rig.take_sent(1), ElementsAre(kDenied));
  Settings next = plant_with({second});
  std::swap(next.devices[0], next.devices[1]);
  next.rules[0].devices = {0};
  rig.reload(next);
  rig.receive(1, write_request(2, 1) + write_request(3, 2));
  EXPECT_THAT(rig.take_sent(1), ElementsAre(kDenied));
  EXPECT_THAT(take_requests(rig), ElementsAre(kWrite2));
}

}  // namespace
}  // namespace mbgate::test
