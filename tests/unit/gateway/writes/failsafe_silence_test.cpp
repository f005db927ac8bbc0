// SPDX-License-Identifier: Apache-2.0
// Failsafe writes for a client that is there, and silent.
#include <gmock/gmock.h>

#include "unit/gateway/writes/failsafe_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

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
