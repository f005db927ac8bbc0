// SPDX-License-Identifier: Apache-2.0
// When failsafe writes are due: who counts, and when that client has gone.
#include <gmock/gmock.h>

#include "unit/gateway/writes/failsafe_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;

TEST_F(FailsafeCauses, NobodyHasGoneWhoNeverWrote) {
  ask(rig_, 1, 1);
  rig_.disconnect(1);
  rig_.connect(2);
  rig_.disconnect(2);
  expect_none(1h);
}

TEST_F(FailsafeCauses, ReadingTheGatewayItselfArmsNothing) {
  rig_.receive(1, "0001 0000 0006 FF 04 0000 0001");
  rig_.disconnect(1);
  expect_none(1h);
}

TEST_F(FailsafeCauses, AStopDoesNotMakeItsClientTheOneThatCounts) {
  write(rig_, 1);
  rig_.connect(2, kPanel);
  rig_.receive(2, stop_request(1));
  EXPECT_THAT(answer_all(rig_), ElementsAre(kStop1));
  rig_.disconnect(2);
  expect_none(1h);
  rig_.disconnect(1);
  rig_.advance(kGrace);
  expect_writes();
}

TEST_F(FailsafeCauses, WhoWroteLastCounts) {
  rig_.connect(2, kPanel);
  write(rig_, 1);
  write(rig_, 2);
  rig_.disconnect(1);
  expect_none(1h);
  rig_.disconnect(2);
  rig_.advance(kGrace);
  expect_writes();
}

TEST_F(FailsafeCauses, AWriteThatIsRefusedDoesNotCount) {
  rig_.connect(2, kPanel, 1);
  write(rig_, 1);
  rig_.receive(2, write_request(1));  // may only read
  rig_.disconnect(2);
  expect_none(1h);
  rig_.disconnect(1);
  rig_.advance(kGrace);
  expect_writes();
}

TEST_F(FailsafeCauses, AnotherClientThatPollsTheDeviceHoldsNothingOff) {
  rig_.connect(2, kPanel);
  write(rig_, 1);
  rig_.disconnect(1);
  rig_.advance(kGrace / 2);
  ask(rig_, 2, 1);
  rig_.advance(kGrace / 2);
  expect_writes();
}

TEST_F(FailsafeCauses, AConnectionOfTheSameClientThatPollsAnotherDriveHoldsNothingOff) {
  rig_.connect(2, kPlc);
  write(rig_, 1);
  rig_.disconnect(1);
  rig_.advance(kGrace / 2);
  ask(rig_, 2, 2);
  rig_.advance(kGrace / 2);
  expect_writes();
}

TEST_F(FailsafeCauses, OneOfTheSameClientThatHasAskedTheDeviceDoes) {
  rig_.connect(2, kPlc);
  write(rig_, 1);
  ask(rig_, 2, 1);
  rig_.disconnect(1);
  expect_none(1h);
  rig_.disconnect(2);
  rig_.advance(kGrace);
  expect_writes();
}

TEST_F(FailsafeCauses, AConnectionForEachWriteIsNoReason) {
  for (std::uint64_t client = 2; client < 12; ++client) {
    rig_.connect(client, kPlc);
    write(rig_, client);
    rig_.disconnect(client);
    expect_none(kGrace / 2);
  }
  rig_.advance(kGrace / 2);
  expect_writes();
}

TEST_F(FailsafeCauses, ANewConnectionWithoutARequestHoldsNothingOff) {
  write(rig_, 1);
  rig_.disconnect(1);
  rig_.connect(2, kPlc);
  rig_.advance(kGrace);
  expect_writes();
}

// Once it is acknowledged, until the next write.
TEST_F(FailsafeCauses, ReadingAfterwardsArmsNothing) {
  write(rig_, 1);
  rig_.disconnect(1);
  rig_.advance(kGrace);
  expect_writes();
  rig_.connect(2, kPlc);
  ask(rig_, 2, 1);
  rig_.disconnect(2);
  expect_none(1h);
}

// Nothing else needs to happen first.
TEST(DisplacedWriter, HasGoneAsSoonAsAnotherHasItsPlace) {
  Settings settings = watched_plant();
  settings.listeners[0].max_connections = 1;
  settings.guards[0].failsafe_grace = 0ms;
  MachineRig rig(settings);
  rig.connect(1);
  write(rig, 1);
  rig.connect(2);  // of the same client
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
}

class FailsafeClients : public FailsafeCauses {
 protected:
  FailsafeClients() : FailsafeCauses(settings()) { rig_.connect(2, kPanel); }
  static Settings settings() {
    Settings settings = watched_plant();
    settings.guards[0].failsafe_clients = {*routing::Network::parse(kPlc)};
    return settings;
  }
};

TEST_F(FailsafeClients, CountWhoeverWrote) {
  ask(rig_, 1, 1);
  write(rig_, 2);
  rig_.disconnect(1);
  rig_.advance(kGrace);
  expect_writes();
}

TEST_F(FailsafeClients, AreTheOnlyOnesThatCount) {
  write(rig_, 1);
  write(rig_, 2);
  rig_.disconnect(2);
  expect_none(1h);
  rig_.disconnect(1);
  rig_.advance(kGrace);
  expect_writes();
}

// What others write while none of them is there stays.
TEST_F(FailsafeClients, HaveNotGoneWhoWereNotThere) {
  ask(rig_, 1, 1);
  rig_.disconnect(1);
  write(rig_, 2);
  expect_none(1h);
}

// It is written to while its failsafe writes are on their way.
TEST_F(FailsafeClients, CountAgainForWhatAnotherWritesBeforeTheyAreAcknowledged) {
  write(rig_, 1);
  rig_.disconnect(1);
  rig_.advance(kGrace);
  rig_.receive(2, write_request(1));
  EXPECT_THAT(answer_all(rig_), ElementsAre(kStop1, kSecond, kWrite1));
  rig_.connect(3, kPlc);
  ask(rig_, 3, 1);
  rig_.disconnect(3);
  rig_.advance(kGrace);
  expect_writes();
}

}  // namespace
}  // namespace mbgate::test
