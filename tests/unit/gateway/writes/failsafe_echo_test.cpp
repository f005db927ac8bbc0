// SPDX-License-Identifier: Apache-2.0
// Failsafe writes on a line of which nobody knows whether it has an echo.
#include <gmock/gmock.h>

#include "unit/gateway/writes/watched_plant.hpp"

namespace mbgate::test {
namespace {

using testing::Contains;
using testing::Not;

/// Client 1 has written and goes; client 2 may only read. The device is left alone after each
/// failsafe write for longer than until the next one.
Settings unknown_line() {
  Settings settings = watched_plant();
  settings.buses[0].line.echo.reset();
  settings.devices[0].timing.quarantine = 3s;
  return settings;
}

class FailsafeEcho : public testing::Test {
 protected:
  FailsafeEcho() {
    rig_.connect(1);
    rig_.connect(2, "192.0.2.2", 1);
    ask(rig_, 2, 1);
    write(rig_, 1);
    rig_.lose_line();
    rig_.open_line();  // it may be another adapter
    rig_.disconnect(1);
    rig_.advance(kGrace);
  }
  /// Client 2 asks twice a second; `answers`: the drive is there, else the line only echoes.
  Lines poll(Duration time, bool answers) {
    Lines requests;
    for (const Instant end = rig_.now() + time; rig_.now() < end;) {
      rig_.receive(2, read_request(7, 1));
      for (int steps = 0; steps < 50; ++steps) {
        for (const auto& request : take_requests(rig_)) {
          requests.push_back(request);
          if (request != kRead1 || !answers) {
            rig_.respond(request);
          } else {
            rig_.respond("01 03 02 00 01");
          }
        }
        rig_.advance(10ms);
      }
    }
    return requests;
  }
  MachineRig rig_{unknown_line()};
};

TEST_F(FailsafeEcho, LetAReadGoThatSettlesIt) {
  EXPECT_THAT(poll(20s, true), Contains(kRead1));
  EXPECT_THAT(rig_.events, Contains(kAcknowledged));
  EXPECT_THAT(rig_.take_sent(2), Contains("00 07 00 00 00 05 01 03 02 00 01"));
}

TEST_F(FailsafeEcho, TakeTurnsWithReadsOfADriveThatIsNotThere) {
  const auto requests = poll(60s, false);
  EXPECT_GE(std::ranges::count(requests, kStop1), 10);
  EXPECT_GE(std::ranges::count(requests, kRead1), 10);
  EXPECT_THAT(rig_.events, Not(Contains(kAcknowledged)));
}

// What may be its echo does not show that a drive is silent: offline, it would get no read.
TEST_F(FailsafeEcho, TakeNoDriveOfflineThatMayHaveAnswered) {
  for (int count = 0; count < 20; ++count) {
    answer_all(rig_, 1s);
  }
  EXPECT_THAT(rig_.events, Not(Contains("device axis-x: does not answer any more")));
  EXPECT_THAT(poll(3s, true), Contains(kRead1));
  EXPECT_THAT(rig_.events, Contains(kAcknowledged));
}

TEST_F(FailsafeEcho, AreSentAsOftenAsEverIfNobodyReads) {
  rig_.advance(10s);
  take_requests(rig_);
  rig_.advance(10s);
  EXPECT_EQ(std::ranges::count(take_requests(rig_), kStop1), 5);
}

}  // namespace
}  // namespace mbgate::test
