// SPDX-License-Identifier: Apache-2.0
// Answers that pause for longer than frame_slack.
#include "unit/bus/bus_rig.hpp"
#include "unit/bus/queue/stop_axis.hpp"

namespace mbgate::test {
namespace {

using BusPause = Bus;

TEST_F(BusPause, IsToldAndIsNoLatenessOfAnEarlierRequest) {
  auto patient = settings();
  patient.timing.response_timeout = 1s;
  open(patient);
  submit(job(kRead));
  advance(2300ms);  // an earlier request was not answered
  submit(job(kOther));
  advance(10ms);
  for (const auto* const piece : {"01 03", "02 12", "34", "B5 33"}) {
    line(piece);
    advance(150ms);
  }
  EXPECT_THAT(notices_, ElementsAre(bus::DeviceNotice::Kind::pauses));
  EXPECT_EQ(last_notice_.lateness, 150ms);
  EXPECT_EQ(bus_->counters().late_responses, 0U);
}

// Two damaged answers, of which the end of the first and the second make a frame by chance.
TEST_F(BusPause, OfAnAddressThatNobodyHasAskedIsNotTold) {
  open(settings(), {});
  for (const auto* const piece : {"57 03", "02 12 34 FD 3F"}) {
    line(piece);
    advance(50ms);
  }
  EXPECT_THAT(notices_, IsEmpty());
  EXPECT_EQ(bus_->devices()[0x57].health.state(), bus::DeviceState::not_asked);
}

TEST_F(BusPause, WithinFrameSlackIsPartOfTheAnswer) {
  auto patient = settings();
  patient.timing.response_timeout = 1s;
  patient.frame_slack = 200ms;
  open(patient);
  submit(job(kRead));
  advance(10ms);
  for (const auto* const piece : {"01 03", "02 12", "34", "B5 33"}) {
    EXPECT_THAT(endings_, IsEmpty());
    advance(150ms);
    line(piece);
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

// The latency timer of an adapter cuts it, and what is sent in between would be lost with it.
TEST_F(BusPause, WithinFrameSlackOfALateAnswerNothingIsSent) {
  open(settings());
  submit(job("03 0000 0004"));
  time_out();
  line("01 03 08 00");
  submit(job_of(1, kRead, 2));
  advance(16ms);
  line("01 00 02 00");
  advance(16ms);
  EXPECT_THAT(frames_, SizeIs(1));
  line("03 00 04 0D 14");
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  EXPECT_EQ(until_next_frame(10ms), kT35);
}

TEST_F(BusPause, OfWhatIsNoBeginningOfAFrameHoldsNothing) {
  open(settings());
  line("FE 03 08 00");
  submit(job(kRead));
  EXPECT_EQ(until_next_frame(30ms), kT35);
  line(kAnswer);
  line("05");  // a byte of noise behind it
  submit(job(kRead));
  EXPECT_EQ(until_next_frame(30ms), kT35);
}

TEST_F(BusPause, OfADeadDriveShowsThatAStopToItIsWorthRepeating) {
  open(settings(), {axis(settings())});
  submit(job(kStop));
  advance(1s);
  ASSERT_THAT(frames_, SizeIs(4));
  line("01 03");
  advance(50ms);
  line("02 12 34 B5 33");
  advance(5ms);
  submit(job(kStop));
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(8));
}

}  // namespace
}  // namespace mbgate::test
