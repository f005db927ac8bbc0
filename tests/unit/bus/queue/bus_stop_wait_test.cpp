// SPDX-License-Identifier: Apache-2.0
// How long a stop waits for the answer to what is on the wire.
#include "stop_axis.hpp"
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test::bus_stop_wait_test {
namespace {

using BusStopWait = Bus;

TEST_F(BusStopWait, AStopWaitsForARunningTransactionsFirstByteNoLongerThanStopWait) {
  auto slow = settings();
  slow.timing.response_timeout = 1s;
  open(slow, {axis(slow)});
  submit(job(kRead, 2));
  advance(20ms);
  submit(job_of(1, kStop));
  EXPECT_EQ(until_next_frame(500ms), kEmission + 80ms);
  EXPECT_EQ(frames_.back(), kStopFrame);
  EXPECT_EQ(endings_.front(), Ending::no_answer);
  // The device that was cut off owes its answer until its own timeout and quarantine are over.
  EXPECT_GT(bus_->parts().held_back(2, now_), 0ms);
}

TEST_F(BusStopWait, AnAnswerOfASlowRegisterMakesNoLaterStopWaitLonger) {
  auto slow = settings();
  slow.timing.response_timeout = 1s;
  drive::Device saving = axis(slow, 2);
  saving.profile.slow = {{{modbus::Table::holding_registers, 0xDC, 1}, 3s}};
  open(slow, {axis(slow), saving});
  submit(job("03 00DC 0001", 2));
  advance(700ms);
  line("02 03 02 12 34 F1 33");
  advance(5ms);
  submit(job("03 00DC 0001", 2));
  advance(20ms);
  submit(job_of(1, kStop));
  EXPECT_EQ(until_next_frame(500ms), kEmission + 80ms);
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusStopWait, NoWriteToItsOwnDeviceGoesBeforeAStopIsRepeated) {
  open(settings(), {axis(settings()), axis(settings(), 2)});
  submit(job(kStop));
  submit(job_of(1, kMove));
  submit(job_of(2, kMove, 2));
  advance(110ms);
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(unhex(frames_[1])[0], 2);
}

TEST_F(BusStopWait, OneThatIsAbandonedHoldsUpNobody) {
  open(settings(), {axis(settings())});
  submit(job(kRead, 2));
  advance(10ms);
  bus::Job& stop = job_of(1, kStop);
  submit(stop);
  submit(job_of(2, kRead));
  bus_->abandon(stop);
  line("02 03 02 12 34 F1 33");
  advance(5ms);
  EXPECT_THAT(frames_, ElementsAre(kOtherDevice, kReadFrame));
  EXPECT_THAT(endings_, testing::UnorderedElementsAre(Ending::answered, Ending::cancelled));
}

// Into an answer that is on its way a stop would be lost.
TEST_F(BusStopWait, AStopWaitsForTwiceTheLongestAnswerOfLate) {
  auto slow = settings();
  slow.timing.response_timeout = 1s;
  open(slow, {axis(slow)});
  constexpr auto kAnswerOf2 = "02 03 02 12 34 F1 33";
  submit(job(kRead, 2));
  advance(300ms);
  line(kAnswerOf2);
  advance(5ms);
  submit(job(kRead, 2));
  advance(20ms);
  submit(job_of(1, kStop));
  advance(400ms);
  EXPECT_THAT(frames_, SizeIs(2));
  line(kAnswerOf2);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  EXPECT_EQ(until_next_frame(10ms), kT35);
  EXPECT_EQ(frames_.back(), kStopFrame);
}

// Each piece may be the beginning of a frame, so that the pause behind it is no silence.
TEST_F(BusStopWait, BeginningsOfFramesDelayAStopNoLongerThanItsDeadline) {
  auto patient = settings();
  patient.stop_deadline = 500ms;
  open(patient, {axis(patient)});
  line("01 03 10");
  submit(job(kStop));
  const Instant since = now_;
  while (now_ < since + 495ms) {
    advance(15ms);
    line("01 03 10");
  }
  EXPECT_THAT(frames_, IsEmpty());
  advance(5ms);
  EXPECT_THAT(frames_, ElementsAre(kStopFrame));
}

}  // namespace
}  // namespace mbgate::test::bus_stop_wait_test
