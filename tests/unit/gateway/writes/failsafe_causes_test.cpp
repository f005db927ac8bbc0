// SPDX-License-Identifier: Apache-2.0
// Other causes for failsafe writes: the gateway stops, clients are silent, the listed one has gone.
#include <gmock/gmock.h>

#include "unit/gateway/writes/watched_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

class FailsafeOnExit : public testing::Test {
 protected:
  static Settings settings() {
    Settings settings = watched_plant();
    settings.guards[0].failsafe_on_exit = true;
    return settings;
  }
  MachineRig rig_{settings()};
};

TEST_F(FailsafeOnExit, SendsThemWhenTheGatewayStops) {
  rig_.connect(1);
  ask(rig_, 1);
  rig_.receive(1, read_request(1, 2) + write_request(2));
  take_requests(rig_);
  rig_.shutdown();
  rig_.respond("02 03 02 00 01");
  rig_.advance(10ms);
  rig_.respond(kStop1);
  rig_.advance(10ms);
  EXPECT_FALSE(rig_.finished);
  rig_.respond(kSecond);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1, kSecond));
  EXPECT_THAT(rig_.events, ElementsAre("device axis-x: the gateway stops; its failsafe writes are "
                                       "sent"));
  EXPECT_TRUE(rig_.finished);
}

TEST_F(FailsafeOnExit, SendsNothingIfNobodyAskedSinceTheyWereSent) {
  rig_.connect(1);
  rig_.shutdown();
  EXPECT_THAT(take_requests(rig_), IsEmpty());
  EXPECT_TRUE(rig_.finished);
}

TEST_F(FailsafeOnExit, SaysWhatCouldNotBeSent) {
  rig_.connect(1);
  ask(rig_, 1);
  rig_.lose_line();
  rig_.shutdown();
  EXPECT_THAT(rig_.events, ElementsAre(kLost,
                                       "device axis-x: its failsafe writes could not be sent "
                                       "before the gateway stopped"));
  EXPECT_TRUE(rig_.finished);
}

TEST(SilentWriters, AreReasonEnoughWhereQuietSaysSo) {
  Settings settings = watched_plant();
  settings.guards[0].quiet = 1s;
  MachineRig rig(settings);
  rig.connect(1);
  rig.advance(900ms);
  rig.receive(1, read_request(1, 2));  // any request counts
  rig.respond("02 03 02 00 01");
  rig.advance(999ms);
  rig.take_transmitted();
  rig.advance(1ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
  rig.respond(kStop1);
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kSecond));
  EXPECT_THAT(rig.events, ElementsAre("device axis-x: the clients that may write are silent; its "
                                      "failsafe writes are sent"));
}

/// The line is given up, and with it the read that was on the wire.
TEST(SilentWriters, AreSilentFromTheAnswerThatAReloadGivesThem) {
  Settings settings = watched_plant();
  settings.guards[0].quiet = 100ms;
  settings.buses[0].timing.response_timeout = 1s;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1, 2));
  rig.advance(90ms);
  take_requests(rig);
  settings.buses[0].line.baud = modbus::Baud{9600};
  rig.reload(settings);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 02 83 0B"));
  rig.open_line();
  rig.advance(99ms);
  EXPECT_THAT(take_requests(rig), IsEmpty());
  rig.advance(1ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

/// A screen, which may write from the reload on that also gives up the line.
TEST(SilentWriters, AreSilentFromThatAnswerThoughTheyMayWriteOnlySinceThen) {
  Settings settings = watched_plant();
  settings.guards[0].quiet = 100ms;
  settings.buses[0].timing.response_timeout = 1s;
  MachineRig rig(settings);
  rig.connect(1);
  rig.connect(2, "192.0.2.1", 1);
  ask(rig, 1);
  rig.receive(2, read_request(1, 2));
  rig.advance(80ms);
  take_requests(rig);
  settings.listeners[1].read_only = {};
  settings.buses[0].line.baud = modbus::Baud{9600};
  rig.reload(settings);
  EXPECT_THAT(rig.take_sent(2), ElementsAre("00 01 00 00 00 03 02 83 0B"));
  rig.open_line();
  rig.advance(99ms);
  EXPECT_THAT(take_requests(rig), IsEmpty());
  rig.advance(1ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

TEST(SilentWriters, AreThoseToWhomNoAnswerIsOwed) {
  Settings settings = watched_plant();
  settings.guards[0].quiet = 100ms;
  settings.devices[1].timing.response_timeout = 1s;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1, 2));
  rig.advance(900ms);
  rig.respond("02 03 02 00 01");
  rig.advance(99ms);
  EXPECT_THAT(rig.events, IsEmpty());
  rig.take_transmitted();
  rig.advance(1ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

TEST(SilentWriters, AreNotThoseWhoseRequestsWaitForTheirTurn) {
  Settings settings = watched_plant();
  settings.guards[0].quiet = 300ms;
  settings.listeners[0].max_requests_per_second = 1;
  settings.listeners[0].pipeline = 4;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1, 2) + read_request(2, 2));
  EXPECT_THAT(take_requests(rig), testing::SizeIs(1));
  rig.respond("02 03 02 00 01");
  rig.advance(900ms);
  EXPECT_THAT(take_requests(rig), IsEmpty());
  rig.advance(100ms);
  EXPECT_THAT(take_requests(rig), testing::SizeIs(1));
  rig.respond("02 03 02 00 01");
  rig.advance(299ms);
  EXPECT_THAT(take_requests(rig), IsEmpty());
  rig.advance(1ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

TEST(SilentWriters, AreThoseOfWhomOnlyAPartOfARequestHasComeWhoeverIsHeldUp) {
  Settings settings = watched_plant();
  settings.guards[0].quiet = 300ms;
  settings.listeners[0].max_requests_per_second = 1;
  MachineRig rig(settings);
  rig.connect(1);
  ask(rig, 1);
  rig.receive(1, "00 01 00");
  rig.advance(289ms);
  EXPECT_THAT(take_requests(rig), IsEmpty());
  rig.advance(1ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

// Nothing else needs to happen first.
TEST(DisplacedWriter, HasGoneAsSoonAsAnotherHasItsPlace) {
  Settings settings = watched_plant();
  settings.listeners[0].max_connections = 1;
  MachineRig rig(settings);
  rig.connect(1);
  ask(rig, 1);
  rig.connect(2);  // of the same client
  EXPECT_THAT(take_requests(rig), testing::ElementsAre(kStop1));
}

TEST(ListedWriter, IsTheOnlyOneThatKeepsFailsafeWritesBack) {
  Settings settings = watched_plant();
  settings.guards[0].writer = gateway::WriterRule::listed;
  settings.guards[0].writers = {*routing::Network::parse("192.0.2.1")};
  MachineRig rig(settings);
  rig.connect(1, "192.0.2.1");
  rig.connect(2, "192.0.2.2");
  ask(rig, 1);
  ask(rig, 2);
  rig.disconnect(1);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

// A screen that stays keeps nothing back, and one that goes is no reason.
TEST(FailsafeClients, AreTheOnlyOnesThatCount) {
  Settings settings = watched_plant();
  settings.guards[0].failsafe_clients = {*routing::Network::parse("192.0.2.1")};
  MachineRig rig(settings);
  rig.connect(1, "192.0.2.1");
  rig.connect(2, "192.0.2.2");
  rig.connect(3, "192.0.2.2");
  ask(rig, 1);
  ask(rig, 2);
  rig.disconnect(3);
  EXPECT_THAT(take_requests(rig), IsEmpty());
  rig.disconnect(1);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

}  // namespace
}  // namespace mbgate::test
