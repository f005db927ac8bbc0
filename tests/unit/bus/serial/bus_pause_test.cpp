// SPDX-License-Identifier: Apache-2.0
// Answers that pause for longer than frame_slack.
#include "unit/bus/bus_rig.hpp"

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

}  // namespace
}  // namespace mbgate::test
