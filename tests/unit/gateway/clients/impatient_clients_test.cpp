// SPDX-License-Identifier: Apache-2.0
// Clients that give up before an answer comes, and take it for the answer to their next request.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// A read of no register: it is refused at once.
constexpr const char* kNothing = "00 02 00 00 00 06 01 03 00 00 00 00";

Settings impatient_plant() {
  Settings settings = stop_plant(64);
  settings.listeners[0].give_up = 50ms;
  return settings;
}

TEST(GiveUp, IsTheDeadlineOfRequests) {
  MachineRig rig(impatient_plant());
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  rig.receive(2, read_request(9, 9));  // nobody answers for 100 ms
  rig.receive(1, write_request(1));
  rig.advance(300ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre(busy(1)));
  EXPECT_THAT(take_requests(rig), testing::Not(testing::Contains(kWrite1)));
}

TEST(GiveUp, NoAnswerGoesOutAfterIt) {
  MachineRig rig(impatient_plant());
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.advance(60ms);
  rig.respond("01 03 02 00 01");
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
  rig.advance(10ms);
  rig.receive(1, read_request(2));
  rig.advance(40ms);
  rig.respond("01 03 02 00 01");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 05 01 03 02 00 01"));
}

TEST(GiveUp, NoRefusalOfAWriteGoesOutAfterItThoughTheProcessStoodStill) {
  MachineRig rig(impatient_plant());
  rig.connect(1);
  rig.stall(60ms);
  rig.receive(1, write_request(1, 250));
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
}

TEST(GiveUp, NoAnswerGoesOutAfterItThatWaitedForTheOneBefore) {
  Settings settings = impatient_plant();
  settings.listeners[0].ordered = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.receive(1, kNothing);
  rig.advance(60ms);
  rig.respond("01 03 02 00 01");
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
}

class OneAtATime : public testing::Test {
 protected:
  OneAtATime() { rig_.connect(1); }
  static Settings settings() {
    Settings settings = stop_plant(64);
    settings.listeners[0].one_at_a_time = true;
    return settings;
  }
  /// While a read is on the wire. That is answered, and then `answer` comes.
  void ask_behind_a_read(const std::string& request, const char* answer) {
    rig_.receive(1, read_request(1));
    rig_.advance(10ms);
    rig_.receive(1, request);
    rig_.respond("01 03 02 00 01");
    rig_.advance(10ms);
    rig_.respond(answer);
  }
  MachineRig rig_{settings()};
};

TEST_F(OneAtATime, ANewRequestReplacesOneThatWaits) {
  rig_.connect(2, "192.0.2.2");
  rig_.receive(2, read_request(9, 2));
  rig_.receive(1, write_request(1));
  rig_.receive(1, read_request(2));
  rig_.advance(10ms);
  rig_.respond("02 03 02 00 01");
  rig_.advance(10ms);
  rig_.respond("01 03 02 00 01");
  EXPECT_THAT(take_requests(rig_), ElementsAre("02 03 00 00 00 01", kRead1));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("00 02 00 00 00 05 01 03 02 00 01"));
}

TEST_F(OneAtATime, OfOneThatWasTransmittedTheAnswerIsDropped) {
  ask_behind_a_read(write_request(2), kWrite1);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(written(2)));
}

TEST_F(OneAtATime, ARequestThatIsRefusedReplacesAnother) {
  rig_.receive(1, read_request(1));
  rig_.advance(10ms);
  rig_.receive(1, kNothing);
  rig_.respond("01 03 02 00 01");
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("00 02 00 00 00 03 01 83 03"));
}

TEST_F(OneAtATime, AStopReplacesAnotherRequest) {
  ask_behind_a_read(stop_request(2), kStop1);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(written(2, 1, true)));
}

TEST_F(OneAtATime, AStopIsNotReplaced) {
  rig_.receive(1, read_request(1));
  rig_.receive(1, stop_request(2));
  rig_.receive(1, read_request(3));
  rig_.respond("01 03 02 00 01");
  rig_.advance(10ms);
  rig_.respond(kStop1);
  rig_.advance(10ms);
  rig_.respond("01 03 02 00 01");
  EXPECT_THAT(rig_.take_sent(1),
              ElementsAre(written(2, 1, true), "00 03 00 00 00 05 01 03 02 00 01"));
}

TEST(OneAtATimeInOrder, TheAnswerToAStopThatWaitsIsNotDropped) {
  Settings settings = stop_plant(64);
  settings.listeners[0].one_at_a_time = settings.listeners[0].ordered = true;
  settings.devices[0].timing.response_timeout = 1s;
  settings.devices[0].timing.retries = 1;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.advance(10ms);
  rig.receive(1, stop_request(2));
  rig.advance(200ms);
  ASSERT_THAT(take_requests(rig), ElementsAre(kRead1, kStop1));
  rig.respond(kStop1);
  rig.receive(1, kNothing);  // the read waits for its next try
  EXPECT_THAT(rig.take_sent(1), ElementsAre(written(2, 1, true), "00 02 00 00 00 03 01 83 03"));
}

TEST(OneAtATimeInOrder, AnAnswerThatWaitsForTheOneBeforeIsDroppedToo) {
  Settings settings = stop_plant(64);
  settings.listeners[0].one_at_a_time = settings.listeners[0].ordered = true;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.receive(1, kNothing);
  rig.advance(10ms);
  rig.receive(1, write_request(3));
  rig.respond("01 03 02 00 01");
  rig.advance(10ms);
  rig.respond(kWrite1);
  EXPECT_THAT(rig.take_sent(1), ElementsAre(written(3)));
}

}  // namespace
}  // namespace mbgate::test
