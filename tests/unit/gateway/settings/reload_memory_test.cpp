// SPDX-License-Identifier: Apache-2.0
// What other settings must not let go: which writes are older than a stop; and whose turns weigh
// more from then on.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;

TEST(ReloadMemory, WritesThatAreOlderThanAStopDoNotFollowIt) {
  MachineRig rig(stop_plant());
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  rig.receive(2, read_request(10) + write_request(11));
  rig.advance(1ms);
  rig.receive(1, stop_request(2));
  rig.reload(stop_plant());
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  rig.respond(kStop1);
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kRead1, kStop1));
  EXPECT_THAT(rig.take_sent(2), ElementsAre("00 0A 00 00 00 05 01 03 02 00 01", busy(11)));
}

TEST(ReloadMemory, WhatWaitsIsNotSentWhereItsUnitLeadsToTheSameAddressOfAnotherLine) {
  Settings settings = stop_plant(16);
  settings.buses.push_back(settings.buses[0]);
  settings.buses[1].name = "line-b";
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1) + write_request(2));
  settings.routes[0].buses = {BusId{1}};
  rig.reload(settings);
  EXPECT_THAT(rig.take_sent(1), ElementsAre(busy(2)));
}

TEST(ReloadMemory, ABroadcastThatWaitsIsNotSentToADeviceThatIsAnotherNow) {
  Settings settings = stop_plant(16);
  settings.routes.emplace_back().buses = {BusId{0}};  // unit 0
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1) + write_request(2, 0));
  settings.devices[1].word_order = drive::WordOrder::big;
  rig.reload(settings);
  EXPECT_THAT(rig.take_sent(1), ElementsAre(busy(2, 0)));
}

TEST(ReloadMemory, NorIsOneOfWhichAPartWasRead) {
  Settings settings = stop_plant();
  settings.routes.emplace_back().buses = {BusId{0}};  // unit 0
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "00 01 00 00 00 06 00 06 00");
  rig.advance(1ms);
  settings.devices[1].word_order = drive::WordOrder::big;
  rig.reload(settings);
  rig.receive(1, "00 00 01");
  EXPECT_THAT(rig.take_sent(1), ElementsAre(busy(1, 0)));
}

/// The bus gets another name, and keeps its port. A read that is asked for then is not sent within
/// `wait`, but is `rest` later.
void expect_wait(MachineRig& rig, Settings settings, bus::Duration wait, bus::Duration rest) {
  settings.buses[0].name = "line-b";
  rig.reload(settings);
  rig.open_line(1);
  rig.receive(1, read_request(2));
  rig.advance(wait);
  EXPECT_THAT(rig.take_transmitted(1), testing::IsEmpty());
  rig.advance(rest);
  EXPECT_THAT(rig.take_transmitted(1), testing::SizeIs(1));
}

TEST(ReloadMemory, ABusThatGetsAnotherNameStillWaitsForLateAnswers) {
  Settings settings = one_bus();
  settings.buses[0].timing.quarantine = 500ms;
  settings.buses[0].timing.retries = 0;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.advance(150ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 83 0B"));
  expect_wait(rig, settings, 400ms, 100ms);
}

TEST(ReloadMemory, ABusThatGetsAnotherNameStillWaitsForADriveThatPausesAfterAWrite) {
  Settings settings = one_bus();
  settings.buses[0].timing.gap_after_write = 500ms;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, write_request(1));
  rig.advance(10ms);
  rig.respond(kWrite1);
  expect_wait(rig, settings, 499ms, 1ms);
}

TEST(ReloadMemory, ABusThatGetsAnotherNameStillWaitsForTheTurnaroundOfABroadcast) {
  Settings settings = one_bus();
  settings.routes.emplace_back().buses = {BusId{0}};  // unit 0
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, write_request(1, 0));
  rig.advance(20ms);  // it has left
  expect_wait(rig, settings, settings.buses[0].turnaround - 20ms, 20ms);
}

/// Unit 1 leads to address 2.
Settings moved(Settings settings) {
  settings.routes[0].first_address = 2;
  return settings;
}

// They were sent to the drive to which the unit led then.
TEST(ReloadMemory, RequestsBehindAFullPipelineDoNotGoToAnotherDrive) {
  MachineRig rig(stop_plant());
  rig.connect(1);
  rig.receive(1, read_request(1) + write_request(2) + read_request(3));
  rig.advance(1ms);
  rig.reload(moved(stop_plant()));
  rig.advance(1ms);
  rig.receive(1, write_request(4));
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kRead1, kWrite2));
  EXPECT_THAT(rig.take_sent(1),
              testing::UnorderedElementsAre(kOne, busy(2), "00 03 00 00 00 03 01 83 06"));
}

TEST(ReloadMemory, NorToTheSameAddressOnAnotherPort) {
  Settings settings = stop_plant(1);
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1) + write_request(2));
  settings.buses[0].line.device = "/dev/ttyS7";
  rig.reload(settings);
  rig.open_line(0);
  rig.take_transmitted(0);
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), testing::IsEmpty());
  EXPECT_THAT(rig.take_sent(1), testing::Contains(busy(2)));
}

TEST(ReloadMemory, NorDoTheyAfterTheUnitHasLedElsewhereAndBack) {
  MachineRig rig(stop_plant());
  rig.connect(1);
  rig.receive(1, read_request(1) + write_request(2) + write_request(3, 2));
  rig.advance(1ms);
  Settings without = stop_plant();
  without.devices.erase(without.devices.begin());
  rig.reload(without);
  rig.reload(stop_plant());
  rig.advance(1ms);
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  EXPECT_THAT(rig.take_sent(1), testing::UnorderedElementsAre(kOne, busy(2)));
  EXPECT_THAT(take_requests(rig), ElementsAre(kRead1, kWrite2));
}

TEST(ReloadMemory, NorToOtherRegistersOfTheSameDrive) {
  MachineRig rig(stop_plant());
  rig.connect(1);
  rig.receive(1, read_request(1) + write_request(2));
  rig.advance(1ms);
  Settings settings = stop_plant();
  auto& window = settings.routes[0].windows.emplace_back();
  window.count = 10;
  window.to = 100;
  rig.reload(settings);
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  EXPECT_THAT(rig.take_sent(1), testing::UnorderedElementsAre(kOne, busy(2)));
}

// The drive was asked, not the gateway.
TEST(ReloadMemory, NorAreTheyAnsweredByTheGatewayItself) {
  MachineRig rig(stop_plant());
  rig.connect(1);
  rig.receive(1, read_request(1) + read_request(2));
  rig.advance(1ms);
  Settings settings = stop_plant();
  settings.status_unit = 1;
  rig.reload(settings);
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  EXPECT_THAT(rig.take_sent(1), testing::UnorderedElementsAre(kOne, "00 02 00 00 00 03 01 83 06"));
}

// However many pieces lie before it, it is no older than it is.
TEST(ReloadMemory, AStopThatComesAfterwardsIsTakenFromBehindAFullPipeline) {
  MachineRig rig(stop_plant());
  rig.connect(1);
  for (unsigned transaction = 1; transaction <= 40; ++transaction) {
    rig.receive(1, read_request(transaction));
    rig.advance(100us);
  }
  rig.reload(moved(stop_plant()));
  rig.advance(1ms);
  rig.receive(1, read_request(41));
  rig.advance(1ms);
  rig.receive(1, "00 2A 00");
  rig.advance(1ms);
  rig.receive(1, "00 00 06 01 06 00");
  rig.advance(1ms);
  rig.receive(1, "7C 00 E1");
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kRead1, kStop2));
}

/// What is sent for a request of which one part came before the reload and the rest behind it.
Lines sent_around_a_reload(const char* part, const char* rest) {
  MachineRig rig(stop_plant());
  rig.connect(1);
  rig.receive(1, part);
  rig.advance(1ms);
  rig.reload(moved(stop_plant()));
  rig.receive(1, rest);
  return take_requests(rig);
}

// What lies in a socket may count as older than it is, and no stop may be lost for that.
TEST(ReloadMemory, AStopThatCountsAsOlderGoesToTheDriveOfToday) {
  EXPECT_THAT(sent_around_a_reload("00 01 00 00 00 06 01 06 00", "7C 00 E1"), ElementsAre(kStop2));
}

// Its client meant another drive, or knew of none.
TEST(ReloadMemory, AWriteThatCountsAsOlderIsRefused) {
  Settings without = stop_plant();
  without.routes[0].first_unit = without.routes[0].first_address = 2;
  for (const auto& [before, after] :
       {std::pair(stop_plant(), moved(stop_plant())), std::pair(without, stop_plant())}) {
    MachineRig rig(before);
    rig.connect(1);
    rig.receive(1, "00 01 00 00 00 06 01 06 00");
    rig.advance(1ms);
    rig.reload(after);
    rig.receive(1, "00 00 01");
    EXPECT_THAT(rig.take_sent(1), ElementsAre(busy(1)));
    EXPECT_THAT(take_requests(rig), testing::IsEmpty());
  }
}

TEST(ReloadMemory, AReadCountsFromWhenItIsUnderstood) {
  EXPECT_THAT(sent_around_a_reload("00 01 00 00 00 06 01 03 00", "00 00 01"),
              ElementsAre("02 03 00 00 00 01"));
}

// The process notices by up to a beat too much how long it stood still.
TEST(ReloadMemory, NorIsAStopThatIsReadAfterAStallOlderThanItsConnection) {
  MachineRig rig(stop_plant());
  rig.advance(1s);
  rig.reload(moved(stop_plant()));
  rig.advance(10ms);
  rig.connect(1);
  rig.advance(600ms);
  rig.harness.handle(gateway::Stalled{700ms});
  rig.receive(1, stop_request(1));
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop2));
}

// Nor did it stand still during the reload.
TEST(ReloadMemory, NorIsAWriteOlderThanAReloadBeforeTheStall) {
  MachineRig rig(stop_plant());
  rig.connect(1);
  rig.advance(1s);
  rig.reload(moved(stop_plant()));
  rig.advance(600ms);
  rig.harness.handle(gateway::Stalled{700ms});
  rig.receive(1, write_request(1));
  EXPECT_THAT(take_requests(rig), ElementsAre(kWrite2));
}

TEST(ReloadMemory, ClientsThatAreThereHaveTheirNewWeights) {
  Settings settings = stop_plant(8);
  MachineRig rig(settings);
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  settings.weights = {{*routing::Network::parse("192.0.2.2"), 3}};
  rig.reload(settings);
  rig.receive(1, read_request(1) + write_request(2) + write_request(3));
  for (unsigned transaction = 1; transaction <= 4; ++transaction) {
    rig.receive(2, write_request(transaction, 2));
  }
  rig.respond("01 03 02 00 01");
  for (const char* next : {kWrite1, kWrite2, kWrite2, kWrite2, kWrite1}) {
    rig.advance(10ms);
    rig.respond(next);
  }
  rig.advance(5ms);
  EXPECT_THAT(take_requests(rig),
              ElementsAre(kRead1, kWrite1, kWrite2, kWrite2, kWrite2, kWrite1, kWrite2));
}

}  // namespace
}  // namespace mbgate::test
