// SPDX-License-Identifier: Apache-2.0
// A read that was sent twice may be answered twice: whose answer is whose, and what waits for the
// other one.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

class BusRepeatedRead : public Bus {
 protected:
  /// The device is known to answer fast. The first transmission is not answered, the second one is
  /// on the wire.
  void repeat() {
    open_retrying();
    submit(job(kRead));
    advance(8ms);
    line(kAnswer);
    advance(10ms);
    endings_.clear();
    frames_.clear();
    frame_times_.clear();
    submit(job(kRead));
    time_out();
    ASSERT_THAT(frames_, SizeIs(2));
  }
  /// Afterwards another read and a write of two others wait.
  void repeat_and_answer() {
    repeat();
    advance(8ms);
    line(kAnswer);
    submit(job_of(1, kOther));
    submit(job_of(2, "06 0000 0001"));
  }
};

TEST_F(BusRepeatedRead, ARetryOfTheSameReadGoesAtOnceAndNobodyJoinsIt) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  retrying.coalesce = true;
  open(retrying);
  submit(job(kRead));
  time_out();
  submit(job_of(1, kRead));
  ASSERT_THAT(frames_, ElementsAre(kReadFrame, kReadFrame));
  advance(20ms);
  line(kAnswer);  // of the first or of the second transmission
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(50ms);
  line(kAnswer);  // of the other one
  EXPECT_THAT(endings_, SizeIs(1));
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  advance(10ms);
  EXPECT_THAT(frames_, SizeIs(3));
  advance(10ms);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

TEST_F(BusRepeatedRead, TwoAnswersInOnePieceAreThoseToBothTries) {
  repeat();
  advance(2ms);
  line(std::string(kAnswer) + " 01 03 02 00 07 F9 86");
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

// The first answer of a read was lost, its retry was answered at once: a write is not for long
// behind it, and another read is.
TEST_F(BusRepeatedRead, AWriteGoesSoonAfterARepeatedReadWasAnswered) {
  repeat_and_answer();
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(until_next_frame(), kT35);
  EXPECT_EQ(frames_[2], "01 06 00 00 00 01 48 0A");
}

// What is owed is the answer to a read; the write between neither clears nor replaces that debt.
TEST_F(BusRepeatedRead, AWriteBetweenLeavesTheReadsHeldBack) {
  repeat_and_answer();
  advance(30ms);
  line("01 06 00 00 00 01 48 0A");
  ASSERT_THAT(frames_, SizeIs(3));
  advance(100ms);
  EXPECT_THAT(frames_, SizeIs(3));
  line(kAnswer);  // at last the other one of the first read
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  advance(10ms);
  ASSERT_THAT(frames_, SizeIs(4));
  EXPECT_EQ(frames_.back(), kOtherFrame);
}

TEST_F(BusRepeatedRead, NoBroadcastComesBetweenThePartsOfAJobThatIsHeldBack) {
  open_retrying();
  bus::Job& parts = job(kRead);
  add(parts, kOther);
  submit(parts);
  submit(job_of(1, "06 0000 0001", 0));
  submit(job_of(2, kRead, 2));
  time_out();
  advance(20ms);
  line(kAnswer);  // of the second transmission: the first may still be answered
  advance(20ms);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2], kOtherDevice);
}

/// Two clients want the same, and it was transmitted for both.
class BusSharedRetries : public BusRepeatedRead {
 protected:
  void send_for_both(unsigned retries) {
    auto retrying = settings();
    retrying.timing.retries = retries;
    retrying.coalesce = true;
    open(retrying);
    submit(job_of(9, "03 0010 0001", 2));
    submit(job_of(0, kRead));
    submit(job_of(1, kRead));  // both wait, and go as one
    line("02 03 02 12 34 F1 33");
  }
};

TEST_F(BusSharedRetries, WhoInheritsThemHasThoseThatAreLeft) {
  send_for_both(2);
  advance(250ms);
  ASSERT_THAT(frames_, ElementsAre("02 03 00 10 00 01 85 FC", kReadFrame, kReadFrame));
  jobs_[1].abandoned = true;
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(4));
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::cancelled, Ending::no_answer));
}

TEST_F(BusSharedRetries, GoOnForTheOtherWhenTheDeadlineOfTheFirstIsOver) {
  send_for_both(1);
  jobs_[1].deadline = now_ + 50ms;
  advance(250ms);
  EXPECT_THAT(frames_, SizeIs(3));
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::expired, Ending::answered));
}

}  // namespace
}  // namespace mbgate::test
