// SPDX-License-Identifier: Apache-2.0
// When failsafe writes are due: who counts, and when that client has gone or is silent.
#include <gmock/gmock.h>

#include "unit/gateway/writes/failsafe_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr auto kPanel = "192.0.2.2";

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

class SilentClient : public FailsafeCauses {
 protected:
  explicit SilentClient(Duration quiet = 3s, Duration timeout = 100ms)
      : FailsafeCauses(settings(quiet, timeout)) {}
  static Settings settings(Duration quiet, Duration timeout) {
    Settings settings = watched_plant();
    settings.guards[0].quiet = quiet;
    settings.devices[0].timing.response_timeout = timeout;
    settings.devices[1].timing.response_timeout = timeout;
    return settings;
  }
};

TEST_F(SilentClient, IsReasonEnoughWhereQuietSaysSo) {
  write(rig_, 1);
  expect_none(2900ms);
  ask(rig_, 1, 1);  // any request to the device counts
  ask(rig_, 1, 2);
  expect_none(2900ms);
  rig_.advance(100ms);
  expect_writes();
  EXPECT_THAT(rig_.events, ElementsAre("device axis-x: the client that counts for it is silent; "
                                       "the device has acknowledged its failsafe writes"));
  expect_none(1h);
}

TEST_F(SilentClient, IsSilentThoughItAsksAnotherDrive) {
  write(rig_, 1);
  rig_.advance(2900ms);
  ask(rig_, 1, 2);
  rig_.advance(100ms);
  expect_writes();
}

// Nobody was heard while the process stood still: what its clients asked lies in the sockets.
TEST_F(SilentClient, WasNotSilentIfItAskedWhileTheProcessStoodStill) {
  write(rig_, 1);
  rig_.stall(5s);
  expect_none(1ms);
  ask(rig_, 1, 1);
  expect_none(2900ms);
  rig_.advance(100ms);
  expect_writes();
}

TEST_F(SilentClient, WhoWritesAfterALongTimeIsNot) {
  rig_.advance(1h);
  rig_.receive(1, write_request(1));
  EXPECT_THAT(take_requests(rig_), ElementsAre(kWrite1));
}

TEST_F(SilentClient, ThatIsListedIsSilentAlthoughAnotherWrites) {
  Settings listed = rig_.harness.settings();
  listed.guards[0].failsafe_clients = {*routing::Network::parse(kPlc)};
  rig_.reload(listed);
  ask(rig_, 1, 1);
  rig_.advance(1min);
  rig_.connect(2, kPanel);
  write(rig_, 2);
  expect_none(2900ms);
  rig_.advance(100ms);
  expect_writes();
}

TEST_F(SilentClient, ThatIsListedIsSilentSinceTheFirstWriteAndNotBefore) {
  Settings listed = rig_.harness.settings();
  listed.guards[0].failsafe_clients = {*routing::Network::parse(kPlc)};
  rig_.reload(listed);
  ask(rig_, 1, 1);
  rig_.advance(1h);
  rig_.connect(2, kPanel);
  rig_.receive(2, write_request(1));
  rig_.advance(5ms);
  rig_.respond(kWrite1);
  take_requests(rig_);
  expect_none(2900ms);
  rig_.advance(100ms);
  expect_writes();
}

class SilentShortly : public SilentClient {
 protected:
  SilentShortly() : SilentClient(10ms) {}
};

TEST_F(SilentShortly, IsSilentNoSoonerThanItsGraceIsOver) {
  write(rig_, 1);
  expect_none(kGrace - 50ms);
  rig_.advance(50ms);
  expect_writes();
}

class SlowDrive : public SilentClient {
 protected:
  SlowDrive() : SilentClient(2s, 5s) {}
};

TEST_F(SlowDrive, MakesNobodySilentWhoWaitsForItsAnswer) {
  write(rig_, 1);
  rig_.receive(1, read_request(1, 1));
  rig_.advance(10ms);
  EXPECT_THAT(take_requests(rig_), SizeIs(1));
  expect_none(4s);
  rig_.respond("01 03 02 00 01");
  expect_none(1900ms);
  rig_.advance(200ms);
  expect_writes();
}

/// The line is given up, and with it the read that was on the wire.
TEST_F(SlowDrive, LetsTheSilenceBeginWithTheAnswerThatAReloadGives) {
  write(rig_, 1);
  rig_.receive(1, read_request(1, 1));
  rig_.advance(1900ms);
  EXPECT_THAT(take_requests(rig_), SizeIs(1));
  Settings changed = rig_.harness.settings();
  changed.buses[0].line.baud = modbus::Baud{9600};
  rig_.reload(changed);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("00 01 00 00 00 03 01 83 0B"));
  rig_.open_line();
  expect_none(1900ms);
  rig_.advance(200ms);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
}

}  // namespace
}  // namespace mbgate::test
