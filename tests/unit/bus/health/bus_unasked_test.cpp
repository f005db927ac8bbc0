// SPDX-License-Identifier: Apache-2.0
// What comes before its time, or was never asked for.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

using Kind = bus::DeviceNotice::Kind;

using BusUnasked = Bus;

TEST_F(BusUnasked, AnEarlyAnswerOfADeviceThatOwesNothingIsTakenAndToldOnce) {
  auto waiting = settings();
  waiting.timing.response_wait = 50ms;
  open(waiting);
  for (unsigned times = 1; times <= 3; ++times) {
    submit(job(kRead));
    advance(20ms);
    line(kAnswer);
    advance(10ms);
    EXPECT_EQ(bus_->counters().early_responses, times);
    EXPECT_THAT(notices_, ElementsAre(Kind::early));
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered, Ending::answered));
}

TEST_F(BusUnasked, FramesOfDevicesThatOweNothingAreForeignTrafficAndToldOnce) {
  open(settings());
  advance(10s);  // what came earlier might have been for whoever had the line before
  line("02 03 02 12 34 F1 33");
  EXPECT_EQ(bus_->counters().foreign_frames, 1U);
  advance(10ms);
  line("02 03 00 00 00 01 84 39");  // another client's request
  advance(10ms);
  line("02 03 02 12 34 F1 33");
  EXPECT_EQ(bus_->counters().foreign_frames, 3U);
  EXPECT_THAT(notices_, ElementsAre(Kind::foreign));
}

// A drive that answers a broadcast is no other client.
TEST_F(BusUnasked, WhatComesWithinTheTurnaroundDelayAnswersTheBroadcast) {
  open(settings());
  advance(10s);
  submit(job("06 0000 0001", 0));
  advance(30ms);
  line("02 06 00 00 00 01 48 39");
  EXPECT_EQ(bus_->counters().foreign_frames, 0U);
  line("03 03 00 00 00 01 85 E8");  // a request is nobody's answer
  EXPECT_EQ(bus_->counters().foreign_frames, 1U);
  advance(200ms);
  line("02 03 02 12 34 F1 33");
  EXPECT_EQ(bus_->counters().foreign_frames, 2U);
}

TEST_F(BusUnasked, AnotherClientsRequestIsNoAnswer) {
  auto breaking = settings();
  breaking.timing.offline_after = 1;
  open(breaking);
  submit(job(kRead));
  time_out();
  line(kOtherFrame);
  advance(10ms);
  line("02");
  EXPECT_TRUE(bus_->devices()[1].health.is_offline());
  EXPECT_EQ(bus_->counters().late_responses, 0U);
}

// It may be the answer to that: it says nothing of what is owed.
TEST_F(BusUnasked, AnAnswerBehindAnotherClientsRequestIsNotCalledLate) {
  open(settings());
  for (int times = 0; times < 2; ++times) {
    submit(job(kRead));
    advance(10ms);
    line(std::string("09 03 00 00 00 01 85 42") + kAnswer);
    advance(11s);
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
  EXPECT_EQ(std::ranges::count(notices_, Kind::late), 0);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  EXPECT_EQ(endings_.back(), Ending::answered);
  EXPECT_EQ(std::ranges::count(notices_, Kind::late), 0);
}

TEST_F(BusUnasked, AFrameOfAnotherLengthIsNoLateAnswer) {
  open(settings());
  submit(job(kRead));
  time_out();
  advance(10s);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  submit(job(kRead));
  advance(10ms);
  line("01 03 04 12 34 56 78 81 07");  // not what was asked for
  EXPECT_THAT(notices_, testing::Not(testing::Contains(Kind::late)));
  EXPECT_EQ(bus_->parts().held_back(1, now_), 0ms);
}

TEST_F(BusUnasked, WhatLiesInTheLineBeforeATransmissionIsNoAnswerToIt) {
  open(settings());
  submit(job(kRead));
  time_out();
  advance(10s);
  unread_ = kAnswer;
  submit(job_of(1, kOther));
  EXPECT_THAT(frames_, SizeIs(1));  // the line is not silent
  advance(5ms);
  EXPECT_THAT(frames_, ElementsAre(kReadFrame, kOtherFrame));
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

}  // namespace
}  // namespace mbgate::test
