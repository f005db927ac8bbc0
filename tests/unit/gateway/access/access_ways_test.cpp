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

}  // namespace
}  // namespace mbgate::test
