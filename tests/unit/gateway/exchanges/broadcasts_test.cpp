// SPDX-License-Identifier: Apache-2.0
// Unit 0: what every device of a bus, or of several, hears.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Gateway, BroadcastsWritesAndKeepsTheTurnaroundDelay) {
  Settings settings = one_bus();
  settings.routes.clear();
  settings.listeners[0].bus = BusId{0};
  settings.listeners[0].broadcast = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 00 06 007C 00E1  0002 0000 0006 01 03 0000 0001");
  EXPECT_THAT(rig.take_transmitted(), ElementsAre("00 06 00 7C 00 E1 89 8B"));
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
  rig.advance(5ms);  // the frame has left the wire after 4.583 ms
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 06 00 06 00 7C 00 E1"));
  rig.advance(99ms);
  EXPECT_THAT(rig.take_transmitted(), IsEmpty());
  rig.advance(1ms);
  EXPECT_EQ(rig.take_transmitted().size(), 1U);
  rig.respond("01 03 02 00 05");
  rig.take_sent(1);
  rig.receive(1, "0003 0000 0006 00 03 0000 0001");  // nobody could answer a read
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 03 00 00 00 03 00 83 01"));
}

TEST(Gateway, BroadcastsToSeveralBusesAndAnswersWhenAllHaveTransmitted) {
  Settings settings = one_bus();
  settings.buses.push_back(settings.buses[0]);
  settings.routes.clear();
  auto& route = settings.routes.emplace_back();
  route.buses = {BusId{0}, BusId{1}};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 00 06 007C 00E1");
  EXPECT_EQ(rig.take_transmitted(0).size() + rig.take_transmitted(1).size(), 2U);
  rig.advance(5ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 06 00 06 00 7C 00 E1"));
  rig.lose_line(1);
  rig.receive(1, "0002 0000 0006 00 06 007C 00E1");
  rig.advance(200ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 00 86 0A"));
}

/// Unit 0 leads to both buses, unit 7 to the second one.
Settings two_lines() {
  Settings settings = one_bus();
  settings.buses.push_back(settings.buses[0]);
  settings.routes.clear();
  settings.routes.emplace_back().buses = {BusId{0}, BusId{1}};
  auto& route = settings.routes.emplace_back();
  route.first_unit = route.last_unit = route.first_address = 7;
  route.buses = {BusId{1}};
  return settings;
}

// The drives of one line have it already.
TEST(Gateway, ABroadcastThatHasBegunIsFinishedThoughItsClientAsksSomethingElse) {
  Settings settings = two_lines();
  settings.listeners[0].one_at_a_time = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  rig.receive(2, "0001 0000 0006 07 03 0000 0001");
  rig.receive(1, "0002 0000 0006 00 06 007C 00E1");
  rig.advance(5ms);
  EXPECT_EQ(rig.take_transmitted(0).size(), 1U);
  EXPECT_EQ(rig.take_transmitted(1).size(), 1U) << "the read";
  rig.receive(1, "0003 0000 0006 07 03 0000 0001");
  rig.respond("07 03 02 00 05", 1);
  rig.advance(5ms);
  EXPECT_THAT(rig.take_transmitted(1), ElementsAre("00 06 00 7C 00 E1 89 8B"));
}

TEST(Gateway, ABroadcastThatOneLineHasGotAndAnotherOneCouldNotHadNoPath) {
  MachineRig rig(two_lines());
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 07 03 0000 0001");
  rig.receive(1, "0002 0000 0006 00 06 007C 00E1");
  rig.advance(5ms);
  EXPECT_EQ(rig.take_transmitted(0).size(), 1U);
  EXPECT_EQ(rig.take_transmitted(1).size(), 1U) << "the read";
  rig.lose_line(1);
  EXPECT_THAT(rig.take_sent(1), testing::UnorderedElementsAre("00 01 00 00 00 03 07 83 0B",
                                                              "00 02 00 00 00 03 00 86 0A"));
}

// Its write is to be repeated when the quarantine is over, and nobody may broadcast before.
TEST(Gateway, BroadcastsAsSoonAsTheClientOfARepeatedWriteHasGone) {
  Settings settings = one_bus();
  settings.routes.clear();
  settings.listeners[0].bus = BusId{0};
  settings.listeners[0].broadcast = true;
  auto& device = settings.devices.emplace_back();
  device.name = "axis";
  device.address = 1;
  device.timing.response_timeout = 100ms;
  device.timing.retry_writes = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.connect(2);
  rig.receive(1, "0001 0000 0006 01 06 0000 0001");
  rig.advance(120ms);
  rig.receive(2, "0002 0000 0006 00 06 007C 00E1");
  EXPECT_EQ(rig.take_transmitted().size(), 1U);
  rig.disconnect(1);
  rig.advance(0ms);
  EXPECT_THAT(rig.take_transmitted(), ElementsAre("00 06 00 7C 00 E1 89 8B"));
}

}  // namespace
}  // namespace mbgate::test
