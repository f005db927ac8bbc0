// SPDX-License-Identifier: Apache-2.0
// Failsafe writes and new settings: what is at the same address of the same port is the same drive.
#include <gmock/gmock.h>

#include "unit/gateway/writes/watched_plant.hpp"

namespace mbgate::test {
namespace {

using testing::AllOf;
using testing::Each;
using testing::ElementsAre;
using testing::Ge;
using testing::IsEmpty;
using testing::Le;
using testing::SizeIs;

class FailsafeReload : public testing::Test {
 protected:
  FailsafeReload() {
    rig_.connect(1);
    write(rig_, 1);
  }
  static Settings renamed() {
    Settings settings = watched_plant();
    settings.devices[0].name = "axis-q";
    return settings;
  }
  MachineRig rig_{watched_plant()};
};

TEST_F(FailsafeReload, ADriveThatIsRenamedIsTheSame) {
  rig_.reload(renamed());
  rig_.advance(1h);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
  rig_.disconnect(1);
  rig_.advance(kGrace);
  EXPECT_THAT(answer_all(rig_), ElementsAre(kStop1, kSecond));
  EXPECT_THAT(rig_.events, ElementsAre("device axis-q: the client that counts for it has gone; the "
                                       "device has acknowledged its failsafe writes"));
}

TEST_F(FailsafeReload, SoIsOneOfARenamedBus) {
  Settings settings = watched_plant();
  settings.buses[0].name = "line-q";
  rig_.reload(settings);
  rig_.open_line(1);
  rig_.advance(1h);
  EXPECT_THAT(take_requests(rig_, 1), IsEmpty());
  rig_.disconnect(1);
  rig_.advance(kGrace);
  EXPECT_THAT(take_requests(rig_, 1), ElementsAre(kStop1));
}

TEST_F(FailsafeReload, DueWritesStayDueWhileTheLineIsReplaced) {
  rig_.lose_line();
  rig_.disconnect(1);
  rig_.advance(kGrace);
  Settings changed = renamed();
  std::swap(changed.devices[0], changed.devices[1]);
  changed.guards.insert(changed.guards.begin(), gateway::DeviceGuard());
  changed.buses[0].line.baud = modbus::Baud{9600};
  rig_.reload(changed);
  EXPECT_THAT(answer_all(rig_), IsEmpty());
  rig_.open_line();
  EXPECT_THAT(answer_all(rig_, 3s), ElementsAre(kStop1, kSecond));
}

TEST_F(FailsafeReload, ADriveThatDoesNotAnswerIsAskedNoMoreOftenForIt) {
  rig_.disconnect(1);
  rig_.advance(kGrace + 20s);
  take_requests(rig_);
  for (int reload = 0; reload < 100; ++reload) {
    rig_.reload(watched_plant());
    rig_.advance(100ms);
  }
  EXPECT_THAT(take_requests(rig_), SizeIs(AllOf(Ge(8), Le(12))));  // two writes each 2 s
}

TEST_F(FailsafeReload, WhatIsUnderWayBeginsAnewWithTheNewWrites) {
  rig_.disconnect(1);
  rig_.advance(kGrace);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  Settings changed = watched_plant();
  std::ranges::reverse(changed.guards[0].failsafe);
  rig_.reload(changed);
  rig_.lose_line();
  rig_.open_line();
  EXPECT_THAT(answer_all(rig_), ElementsAre(kSecond, kStop1));
}

TEST_F(FailsafeReload, WhatWasUnderWayIsNotRepeatedForAClientThatAsksAgain) {
  rig_.disconnect(1);
  rig_.advance(kGrace);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  rig_.reload(watched_plant());
  rig_.connect(2);
  rig_.receive(2, read_request(1, 1));
  rig_.advance(4s);
  EXPECT_THAT(take_requests(rig_), Each(kRead1));
}

TEST_F(FailsafeReload, ThatTakesTheWritesAwayEndsThem) {
  rig_.disconnect(1);
  rig_.advance(kGrace);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  Settings changed = watched_plant();
  changed.guards.clear();
  rig_.reload(changed);
  rig_.lose_line();
  rig_.open_line();
  rig_.advance(1min);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
}

TEST_F(FailsafeReload, ThatTakesTheClientsListenerAwayEndsItsConnection) {
  Settings changed = watched_plant();
  changed.listeners.erase(changed.listeners.begin());
  rig_.reload(changed);
  EXPECT_TRUE(rig_.closed.contains(1));
  rig_.advance(kGrace);
  EXPECT_THAT(answer_all(rig_), ElementsAre(kStop1, kSecond));
}

TEST_F(FailsafeReload, ThatTakesADriveAwayWritesNothingAndSaysSo) {
  Settings changed = watched_plant();
  changed.devices[0].address = 5;  // another drive
  rig_.reload(changed);
  rig_.disconnect(1);
  rig_.advance(1h);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
  EXPECT_THAT(rig_.events,
              ElementsAre("bus line-a: address 1: a reload has removed the device; its failsafe "
                          "writes are not sent any more, although clients have written to it"));
}

TEST_F(FailsafeReload, ADriveThatNobodyHasWrittenToMayGoWithoutAWord) {
  Settings changed = watched_plant();
  std::swap(changed.devices[0].address, changed.devices[1].address);
  MachineRig rig(changed);
  rig.connect(1);
  ask(rig, 1, 1);
  changed.devices.pop_back();
  rig.reload(changed);
  EXPECT_THAT(rig.events, IsEmpty());
}

TEST_F(FailsafeReload, WhoCountsIsWhomTheNewSettingsName) {
  rig_.connect(2, "192.0.2.2");
  ask(rig_, 2, 1);
  Settings changed = watched_plant();
  changed.guards[0].failsafe_clients = {*routing::Network::parse("192.0.2.2")};
  rig_.reload(changed);
  rig_.disconnect(1);
  rig_.advance(1h);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
  rig_.disconnect(2);
  rig_.advance(kGrace);
  EXPECT_THAT(answer_all(rig_), ElementsAre(kStop1, kSecond));
}

}  // namespace
}  // namespace mbgate::test
