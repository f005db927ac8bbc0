// SPDX-License-Identifier: Apache-2.0
// How failsafe writes are sent: until the drive has acknowledged them.
#include <gmock/gmock.h>

#include "unit/gateway/writes/watched_plant.hpp"

namespace mbgate::test {
namespace {

using testing::Contains;
using testing::Each;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

class FailsafeWrites : public testing::Test {
 protected:
  explicit FailsafeWrites(Settings settings = watched_plant()) : rig_(std::move(settings)) {
    rig_.connect(1);
    write(rig_, 1);
  }
  /// The one that wrote goes, and its time is over.
  void leave() {
    rig_.disconnect(1);
    rig_.advance(kGrace);
  }
  MachineRig rig_;
};

TEST_F(FailsafeWrites, AreSentInOrderAndOnceTheyAreAcknowledgedNoMore) {
  rig_.disconnect(1);
  rig_.advance(kGrace - 1ms);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
  rig_.advance(1ms);
  EXPECT_THAT(answer_all(rig_), ElementsAre(kStop1, kSecond));
  EXPECT_THAT(rig_.events, ElementsAre(kAcknowledged));
  rig_.advance(1h);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
}

// Nobody else asks anything.
TEST_F(FailsafeWrites, AreTheProbeOfADriveThatDoesNotAnswer) {
  leave();
  rig_.advance(10s);  // all tries, and then it is offline
  EXPECT_THAT(rig_.events, Contains(kNotYet));
  EXPECT_THAT(rig_.events, testing::Not(Contains(kAcknowledged)));
  rig_.take_transmitted();
  rig_.advance(20s);
  const Lines probes = take_requests(rig_);
  EXPECT_THAT(probes, SizeIs(20));  // both, every 2 s
  EXPECT_THAT(answer_all(rig_, 5s), testing::UnorderedElementsAre(kStop1, kSecond));
  EXPECT_THAT(rig_.events, Contains(kAcknowledged));
  rig_.take_transmitted();
  rig_.advance(1h);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
}

TEST_F(FailsafeWrites, ThatARefusalMetAreSentAgain) {
  leave();
  for (int tries = 0; tries < 4; ++tries) {
    EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
    rig_.respond("01 86 06");
    rig_.advance(10ms);
    if (tries == 0) {
      EXPECT_THAT(take_requests(rig_), ElementsAre(kSecond));  // between two tries of the other
      rig_.respond(kSecond);
    }
    rig_.advance(100ms);
  }
  EXPECT_THAT(rig_.events,
              ElementsAre("device axis-x: a stop command was refused with exception 0x06 (server "
                          "device busy)",
                          kNotYet));
  EXPECT_THAT(answer_all(rig_, 3s), ElementsAre(kStop1));
  EXPECT_EQ(rig_.events.back(), kAcknowledged);
}

TEST_F(FailsafeWrites, AreNotSentWhenTheGatewayStops) {
  rig_.shutdown();
  rig_.disconnect(1);
  rig_.advance(kGrace);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
  EXPECT_TRUE(rig_.finished);
}

TEST_F(FailsafeWrites, AreEndedBeforeTheGatewayIs) {
  leave();
  rig_.shutdown();
  EXPECT_FALSE(rig_.finished);
  EXPECT_THAT(answer_all(rig_), ElementsAre(kStop1, kSecond));
  EXPECT_TRUE(rig_.finished);
}

TEST_F(FailsafeWrites, IntoALineThatIsClosedDoNotCountAsSent) {
  rig_.lose_line();
  leave();
  rig_.advance(1min);
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet));
  EXPECT_THAT(rig_.take_transmitted(), IsEmpty());
  rig_.open_line();
  EXPECT_THAT(answer_all(rig_, 3s), ElementsAre(kStop1, kSecond));
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet, "bus line-a is open", kAcknowledged));
}

TEST_F(FailsafeWrites, StayDueOneByOne) {
  leave();
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  rig_.respond(kStop1);
  rig_.advance(10ms);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kSecond));
  rig_.lose_line();
  rig_.open_line();
  // The first answer may be that to what was on the wire when the line was lost.
  EXPECT_THAT(answer_all(rig_, 3s), ElementsAre(kSecond, kSecond));
  EXPECT_THAT(rig_.events, ElementsAre(kLost, "bus line-a is open", kAcknowledged));
}

TEST_F(FailsafeWrites, AreNotRepeatedForAClientThatAsksAgain) {
  leave();
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  rig_.connect(2);
  rig_.receive(2, read_request(1, 1));
  rig_.advance(4s);
  EXPECT_THAT(take_requests(rig_), Each(kRead1));
}

TEST_F(FailsafeWrites, AreNoLongerDueWhenTheClientThatCountsAsksTheDeviceAgain) {
  rig_.lose_line();
  leave();
  rig_.advance(2s);  // the line has not been opened in time
  rig_.connect(2);   // is no reason yet
  rig_.receive(2, read_request(1, 2));
  rig_.connect(3, "192.0.2.3");
  rig_.receive(3, read_request(1, 1));  // does not count
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet));
  rig_.receive(2, read_request(1, 1));
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet, kBack));
  rig_.open_line();
  rig_.advance(1min);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
  leave();
  rig_.disconnect(2);
  rig_.advance(kGrace);
  EXPECT_THAT(answer_all(rig_), ElementsAre(kStop1, kSecond));
}

TEST_F(FailsafeWrites, ThatWereNotAcknowledgedAreSaidAtTheEnd) {
  rig_.lose_line();
  leave();
  rig_.shutdown();
  EXPECT_THAT(rig_.events,
              ElementsAre(kLost,
                          "device axis-x: not all of its failsafe writes were acknowledged before "
                          "the gateway stopped"));
  EXPECT_TRUE(rig_.finished);
}

TEST_F(FailsafeWrites, ThatWaitForTheirNextTryAreSaidToo) {
  Settings patient = rig_.harness.settings();
  patient.devices[0].timing.probe_interval = 10s;
  rig_.reload(patient);
  rig_.lose_line();
  leave();
  rig_.advance(3s);
  rig_.shutdown();
  EXPECT_THAT(rig_.events, ElementsAre(kLost, kNotYet,
                                       "device axis-x: not all of its failsafe writes were "
                                       "acknowledged before the gateway stopped"));
  EXPECT_TRUE(rig_.finished);
}

class FailsafeOnExit : public FailsafeWrites {
 protected:
  FailsafeOnExit() : FailsafeWrites(settings()) {}
  static Settings settings() {
    Settings settings = watched_plant();
    settings.guards[0].failsafe_on_exit = true;
    return settings;
  }
};

TEST_F(FailsafeOnExit, SendsThemWhenTheGatewayStops) {
  rig_.receive(1, read_request(1, 2) + write_request(2));
  take_requests(rig_);
  rig_.shutdown();
  rig_.respond("02 03 02 00 01");
  EXPECT_THAT(answer_all(rig_), ElementsAre(kStop1, kSecond));
  EXPECT_THAT(
      rig_.events,
      ElementsAre(
          "device axis-x: the gateway stops; the device has acknowledged its failsafe writes"));
  EXPECT_TRUE(rig_.finished);
}

TEST_F(FailsafeOnExit, SendsNothingIfNobodyWroteSinceTheyWereAcknowledged) {
  leave();
  answer_all(rig_);
  rig_.shutdown();
  EXPECT_THAT(take_requests(rig_), IsEmpty());
  EXPECT_TRUE(rig_.finished);
}

TEST_F(FailsafeOnExit, SaysWhatWasNotAcknowledged) {
  rig_.lose_line();
  rig_.shutdown();
  EXPECT_THAT(rig_.events, ElementsAre(kLost,
                                       "device axis-x: not all of its failsafe writes were "
                                       "acknowledged before the gateway stopped"));
  EXPECT_TRUE(rig_.finished);
}

TEST(FailsafeWritesOfOne, AreSentAtOnceBesideADeviceThatNeedsNone) {
  Settings settings = watched_plant();
  settings.guards.resize(2);
  settings.guards[1] = settings.guards[0];
  MachineRig rig(settings);
  rig.connect(1);
  write(rig, 1);
  rig.disconnect(1);
  rig.advance(kGrace);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

// What it asks the other drive leaves it nothing for this one.
TEST(FailsafeWritesOfOne, AreNotSentWhereItsClientAsksThoughItGets06) {
  Settings settings = watched_plant();
  settings.guards[0].quiet = 3s;
  settings.listeners[0].max_requests_per_second = 1;
  MachineRig rig(settings);
  rig.connect(1);
  write(rig, 1);
  rig.advance(2900ms);
  rig.receive(1, read_request(1, 2) + read_request(2, 1));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 01 83 06"));
  rig.advance(5ms);
  rig.respond("02 03 02 00 01");
  take_requests(rig);
  rig.advance(2900ms);
  EXPECT_THAT(take_requests(rig), IsEmpty());
  rig.advance(100ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

}  // namespace
}  // namespace mbgate::test
