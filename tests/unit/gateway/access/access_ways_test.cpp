// SPDX-License-Identifier: Apache-2.0
// Access rules in the machine, by every way that a request has to a drive.
#include <gmock/gmock.h>

#include "unit/gateway/access/access_plant.hpp"

namespace mbgate::test {
namespace {

using modbus::Table;
using testing::Contains;
using testing::ElementsAre;
using testing::IsEmpty;

constexpr auto kStopWithFive = "0002 0000 0013 01 10 007C 0006 0C 00E1 0001 0002 0003 0004 0005";

AccessRule stops(bool permits) {
  AccessRule made = rule(permits, "stops");
  made.registers.stops = true;
  return made;
}

Settings plant_of_opcodes(std::vector<AccessRule> rules) {
  Settings settings = plant_with(std::move(rules));
  settings.devices[0].profile.stops[0].parameters = 5;
  return settings;
}

TEST(AccessInTheMachine, AStopIsPermittedAloneAndNotWithWhatIsWrittenBehindIt) {
  MachineRig rig(plant_of_opcodes({stops(true)}));
  rig.connect(1);
  rig.receive(1, kStopWithFive);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 01 90 01"));
  EXPECT_THAT(take_requests(rig), IsEmpty());
  rig.receive(1, stop_request(3));
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
  AccessRule with_parameters = stops(true);
  with_parameters.registers.spans = {{Table::holding_registers, 0x7D, 0x81}};
  MachineRig other(plant_of_opcodes({with_parameters}));
  other.connect(1);
  other.receive(1, kStopWithFive);
  EXPECT_THAT(take_requests(other),
              ElementsAre("01 10 00 7C 00 06 0C 00 E1 00 01 00 02 00 03 00 04 00 05"));
}

TEST(AccessInTheMachine, WhateverHoldsAStopIsDeniedWhereStopsAre) {
  MachineRig rig(plant_of_opcodes({stops(false), rule(true, "")}));
  rig.connect(1);
  rig.receive(1, kStopWithFive);
  rig.receive(1, "0003 0000 000B 01 10 007B 0002 04 0000 00E1");
  rig.receive(1, "0004 0000 0008 01 16 007C 0000 00E1");
  rig.receive(1, "0005 0000 000D 01 17 0000 0001 007C 0001 02 00E1");
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 02 00 00 00 03 01 90 01", "00 03 00 00 00 03 01 90 01",
                          "00 04 00 00 00 03 01 96 01", "00 05 00 00 00 03 01 97 01"));
  rig.receive(1, "0006 0000 000B 01 10 007B 0002 04 0000 0001");
  EXPECT_THAT(take_requests(rig), ElementsAre("01 10 00 7B 00 02 04 00 00 00 01"));
}

TEST(AccessInTheMachine, ATransparentListenerHasRulesToo) {
  AccessRule locked = rule(false, "axis-y");
  locked.devices = {1};
  locked.access = routing::RuleAccess::write;
  Settings settings = plant_with({locked, rule(true, "")});
  settings.routes.clear();
  settings.listeners[0].bus = BusId{0};
  settings.listeners[0].broadcast = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, write_request(2, 2) + write_request(3, 0) + write_request(4, 1));
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 02 00 00 00 03 02 86 01", "00 03 00 00 00 03 00 86 01"));
  EXPECT_THAT(take_requests(rig), ElementsAre(kWrite1));
}

TEST(AccessInTheMachine, AnAddressWithoutADeviceIsNoneOfTheDevicesThatARuleNames) {
  AccessRule both = rule(true, "axes");
  both.devices = {0, 1};
  MachineRig rig(plant_with({both}));
  rig.connect(1);
  rig.receive(1, write_request(2, 3) + write_request(3, 1));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 03 86 01"));
  EXPECT_THAT(take_requests(rig), ElementsAre(kWrite1));
}

TEST(AccessInTheMachine, AMaskWriteIsAWriteOfItsRegister) {
  AccessRule some = rule(true, "some");
  some.access = routing::RuleAccess::write;
  some.registers.spans = {{Table::holding_registers, 20, 29}};
  constexpr auto kMask = "0001 0000 0008 01 16 0013 FFFF 0000  0002 0000 0008 01 16 0014 FFFF 0000";
  MachineRig rig(plant_with({some}));
  rig.connect(1);
  rig.receive(1, kMask);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 96 01"));
  EXPECT_THAT(take_requests(rig), ElementsAre("01 16 00 14 FF FF 00 00"));
  MachineRig reads(plant_with({reading()}));
  reads.connect(1);
  reads.receive(1, kMask);
  EXPECT_THAT(reads.take_sent(1),
              ElementsAre("00 01 00 00 00 03 01 96 01", "00 02 00 00 00 03 01 96 01"));
  EXPECT_THAT(take_requests(reads), IsEmpty());
}

// A function of the maker's own is a write, and names no registers.
TEST(AccessInTheMachine, AnUnknownFunctionIsPermittedByNoRuleWithRegisters) {
  constexpr auto kVendor = "0001 0000 0004 01 41 AABB";
  AccessRule holding = rule(true, "holding");
  holding.registers.spans = {routing::RegisterSpan{}};
  for (const AccessRule& permit : {reading(), holding}) {
    MachineRig rig(plant_with({permit}));
    rig.connect(1);
    rig.receive(1, kVendor);
    EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 C1 01"));
    EXPECT_THAT(take_requests(rig), IsEmpty());
  }
  AccessRule named = rule(true, "vendor");
  named.functions.emplace().set(0x41);
  MachineRig rig(plant_with({named}));
  rig.connect(1);
  rig.receive(1, kVendor);
  EXPECT_THAT(take_requests(rig), ElementsAre("01 41 AA BB"));
}

TEST(AccessInTheMachine, TheIdentificationIsReadAndItsOtherKindsAreWritten) {
  MachineRig rig(plant_with({reading()}));
  rig.connect(1);
  rig.receive(1, "0001 0000 0004 01 2B 0D 00  0002 0000 0005 01 2B 0E 01 00");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 AB 01"));
  EXPECT_THAT(take_requests(rig), ElementsAre("01 2B 0E 01 00"));
}

// Client 2 may read register 1, and client 1 everything.
class SharedAnswers : public testing::Test {
 protected:
  static Settings plant() {
    AccessRule narrow = rule_for("192.0.2.2");
    narrow.access = routing::RuleAccess::read;
    narrow.registers.spans = {{Table::holding_registers, 1, 1}};
    Settings settings = plant_with({rule_for("192.0.2.1"), narrow});
    settings.buses[0].coalesce = true;
    settings.devices[0].cache = 1s;
    return settings;
  }
  SharedAnswers() : rig_(plant()) {
    rig_.connect(1, "192.0.2.1");
    rig_.connect(2, "192.0.2.2");
  }
  MachineRig rig_;
};

TEST_F(SharedAnswers, OfReadsThatWaitAreForThoseAloneWhoMayAsk) {
  rig_.receive(1, read_request(9, 2));  // keeps the line busy
  rig_.receive(1, "0001 0000 0006 01 03 0001 0001");
  rig_.receive(2, read_request(2) + "0003 0000 0006 01 03 0000 0002");
  EXPECT_THAT(rig_.take_sent(2),
              ElementsAre("00 02 00 00 00 03 01 83 01", "00 03 00 00 00 03 01 83 01"));
  rig_.receive(2, "0004 0000 0006 01 03 0001 0001");
  EXPECT_THAT(take_requests(rig_), ElementsAre("02 03 00 00 00 01"));
  rig_.respond("02 03 02 00 01");
  rig_.advance(10ms);
  EXPECT_THAT(take_requests(rig_), ElementsAre("01 03 00 01 00 01"));
  rig_.respond("01 03 02 00 02");
  EXPECT_THAT(rig_.take_sent(1), Contains("00 01 00 00 00 05 01 03 02 00 02"));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre("00 04 00 00 00 05 01 03 02 00 02"));
}

TEST_F(SharedAnswers, ThatAreKeptAreForThoseAloneWhoMayAsk) {
  rig_.receive(1, read_request(1));
  rig_.respond("01 03 02 00 01");
  rig_.advance(10ms);
  take_requests(rig_);
  rig_.take_sent(1);
  rig_.receive(2, read_request(2));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre("00 02 00 00 00 03 01 83 01"));
  rig_.receive(1, read_request(1));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kOne));
  EXPECT_THAT(take_requests(rig_), IsEmpty());
}

class BroadcastOfAutonics : public testing::Test {
 protected:
  /// What goes on the line when the write of unit 129 is asked; else what the client gets.
  static Lines asked_with(const AccessRule& denies) {
    Settings settings = plant_with({denies, rule(true, "")});
    for (drive::Device& device : settings.devices) {
      device.profile.broadcast.form = drive::BroadcastForm{129, 0x80};
    }
    settings.routes.emplace_back().buses = {BusId{0}};  // unit 0
    MachineRig rig(settings);
    rig.connect(1);
    rig.receive(1, write_request(2, 129));
    const Lines transmitted = take_requests(rig);
    return transmitted.empty() ? rig.take_sent(1) : transmitted;
  }
};

TEST_F(BroadcastOfAutonics, ReachesNoUnitAndNoDeviceThatIsDenied) {
  constexpr auto kRefused = "00 02 00 00 00 03 81 86 01";
  AccessRule unit = rule(false, "unit 2");
  unit.units.emplace().set(2);
  EXPECT_THAT(asked_with(unit), ElementsAre(kRefused));
  AccessRule all = rule(false, "unit 0");
  all.units.emplace().set(0);
  EXPECT_THAT(asked_with(all), ElementsAre(kRefused));
  AccessRule device = rule(false, "axis-y");
  device.devices = {1};
  EXPECT_THAT(asked_with(device), ElementsAre(kRefused));
  device.registers.spans = {{Table::holding_registers, 0, 0}};
  EXPECT_THAT(asked_with(device), ElementsAre(kRefused));
  device.registers.spans = {{Table::holding_registers, 1, 1}};
  EXPECT_THAT(asked_with(device), ElementsAre("81 86 00 00 00 01"));
}

TEST(AccessInTheMachine, ARequestPastTheLastAddressComesBackAtNoOther) {
  AccessRule end = reading();
  end.registers.spans = {{Table::holding_registers, 0xFFF0, 0xFFFF}};
  AccessRule begin = rule(true, "begin");
  begin.units.emplace().set(2);
  begin.registers.spans = {{Table::holding_registers, 0, 9}};
  MachineRig rig(plant_with({end, begin}));
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 01 03 FFFF 0002  0002 0000 000B 01 10 FFFF 0002 04 0001 0001");
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 01 00 00 00 03 01 83 02", "00 02 00 00 00 03 01 90 01"));
  EXPECT_THAT(take_requests(rig), IsEmpty());
  rig.receive(1, "0003 0000 0006 01 03 FFFF 0001");
  EXPECT_THAT(take_requests(rig), ElementsAre("01 03 FF FF 00 01"));
}

}  // namespace
}  // namespace mbgate::test
