// SPDX-License-Identifier: Apache-2.0
// Failsafe writes of a drive that other settings take away: they were due before, or are because of
// it.
#include <gmock/gmock.h>

#include "unit/gateway/writes/watched_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr auto kSentToTheGone =
    "bus line-a: address 1: the last client that may write has gone; its failsafe writes are sent";

constexpr auto kSentToTheLeaving =
    "bus line-a: address 1: a reload has taken its device away; its failsafe writes are sent";

/// The drive goes, and with it the listener of the client that has set it going.
Settings without_drive() {
  Settings settings = watched_plant();
  settings.listeners.erase(settings.listeners.begin());
  settings.devices.erase(settings.devices.begin());
  settings.guards.clear();
  return settings;
}

TEST(FailsafeReload, ADriveThatGoesWithItsLastClientGetsItsWrites) {
  MachineRig rig(watched_plant());
  rig.connect(1);
  ask(rig, 1);
  rig.reload(without_drive());
  EXPECT_TRUE(rig.closed.contains(1));
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
  rig.respond(kStop1);
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kSecond));
  EXPECT_THAT(rig.events, ElementsAre(kSentToTheGone));
}

TEST(FailsafeReload, SoDoesOneThatGoesAloneBecauseNobodyMayWriteToItAnyMore) {
  MachineRig rig(watched_plant());
  rig.connect(1);
  ask(rig, 1);
  Settings settings = without_drive();
  settings.listeners = watched_plant().listeners;
  rig.reload(settings);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

TEST(FailsafeReload, ADriveThatMovesGetsThemWhereItWas) {
  MachineRig rig(watched_plant());
  rig.connect(1);
  ask(rig, 1);
  Settings settings = watched_plant();
  settings.devices[0].address = 5;
  rig.reload(settings);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
  rig.respond(kStop1);
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kSecond));
  EXPECT_THAT(rig.events, ElementsAre(kSentToTheLeaving));
}

TEST(FailsafeReload, ADriveThatNobodyHasSetGoingGetsNone) {
  MachineRig rig(watched_plant());
  rig.connect(1);
  rig.reload(without_drive());
  rig.advance(1s);
  EXPECT_THAT(take_requests(rig), IsEmpty());
  EXPECT_THAT(rig.events, IsEmpty());
}

TEST(FailsafeReload, OfADriveThatIsRenamedWhileItsLineIsAwayItIsSaidThatTheyWereNotSent) {
  MachineRig rig(watched_plant());
  rig.connect(1);
  ask(rig, 1);
  rig.lose_line();
  rig.disconnect(1);
  Settings renamed = watched_plant();
  renamed.devices[0].name = "axis-q";
  rig.reload(renamed);
  EXPECT_THAT(rig.events,
              ElementsAre(kLost,
                          "device axis-x: the last client that may write has gone; its failsafe "
                          "writes could not be sent yet",
                          "device axis-q: a reload has taken the device of before away; its "
                          "failsafe writes were not all sent"));
}

}  // namespace
}  // namespace mbgate::test
