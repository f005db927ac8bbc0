// SPDX-License-Identifier: Apache-2.0
// Stops on a connection, where others may be on their way.
#include "bus_tcp_rig.hpp"
#include "unit/bus/queue/stop_axis.hpp"

namespace mbgate::test {
namespace {

// The transaction identifier tells answers apart, so nothing collides.
TEST_F(BusTcp, AStopGoesAtOnceBeyondOutstandingAndCutsNothing) {
  auto slow = tcp(1);
  slow.timing.response_timeout = 1s;
  open(slow, {axis(slow, 3)});
  submit(job_of(1, kMove, 3));
  submit(job_of(2, kStop, 3));
  EXPECT_THAT(units(), ElementsAre(3, 3));
  advance(900ms);
  EXPECT_THAT(endings_, IsEmpty());
}

TEST_F(BusTcp, TwoStopsToOneDeviceGoOneAfterTheOther) {
  open(tcp(2), {axis(tcp(2), 3)});
  submit(job_of(0, kStop, 3));
  submit(job_of(1, kStopBy16, 3));
  EXPECT_THAT(frames_, SizeIs(1));
  answer(0, std::string("03 ") + kStop);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusTcp, AndNeitherCutsTheOtherShort) {
  auto slow = tcp();
  slow.timing.response_timeout = 1s;
  open(slow, {axis(slow, 3)});
  submit(job_of(0, kStop, 3));
  submit(job_of(1, kStopBy16, 3));
  advance(150ms);
  answer(0, std::string("03 ") + kStop);
  advance(150ms);
  answer(1, "03 10 00 7C 00 01");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusTcp, WhatGoesBetweenTwoTriesOfAStopIsNotCutOffByTheStopBesideIt) {
  auto slow = tcp(2);
  slow.timing.response_timeout = 1s;
  open(slow, {axis(settings(), 2), axis(settings(), 3)});
  submit(job_of(0, kRead, 2));
  submit(job_of(1, kStop, 3));
  submit(job_of(2, kRead, 1));
  advance(settings().timing.response_timeout);
  ASSERT_THAT(units(), ElementsAre(2, 3, 1, 3));
  advance(250ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer)) << "only the read of 2";
}

TEST_F(BusTcp, AStopIsNotJoinedByTheNextPartOfARead) {
  open(tcp(2), {axis(settings())});
  auto& read = job(kRead);
  add(read, kOther);
  submit(read);
  submit(job(kStop));
  ASSERT_THAT(frames_, SizeIs(2));
  answer(0, "01 03 02 12 34");
  advance(10ms);
  EXPECT_THAT(frames_, SizeIs(2));
  answer(1, std::string("01 ") + kStop);
  advance(10ms);
  EXPECT_THAT(frames_, SizeIs(3));
}

TEST_F(BusTcp, NorWhileAStopToAnotherDeviceGivesWay) {
  open(tcp(3), {axis(settings()), axis(settings(), 2)});
  auto& read = job(kRead);
  add(read, kOther);
  submit(read);
  submit(job_of(1, kStop, 2));
  advance(50ms);
  submit(job_of(2, kStop));
  answer(0, "01 03 02 12 34");
  advance(50ms);  // the response timeout of the first stop has ended
  EXPECT_THAT(units(), ElementsAre(1, 2, 1, 2));
}

TEST_F(BusTcp, NorByTheRepetitionOfARead) {
  auto repeating = tcp(2);
  repeating.timing.retries = 1;
  open(repeating, {axis(repeating)});
  submit(job(kRead));
  advance(90ms);
  submit(job(kStop));
  ASSERT_THAT(frames_, SizeIs(2));
  advance(20ms);  // the response timeout of the read has ended
  EXPECT_THAT(frames_, SizeIs(2));
  answer(1, std::string("01 ") + kStop);
  advance(10ms);
  EXPECT_THAT(frames_, SizeIs(3));
}

TEST_F(BusTcp, ALateAnswerBringsItsDeviceBack) {
  auto breaking = tcp(1);
  breaking.timing.offline_after = 1;
  open(breaking);
  submit(job(kRead, 1));
  advance(breaking.timing.response_timeout);
  EXPECT_TRUE(bus_->devices()[1].health.is_offline());
  answer(0, "01 03 02 12 34");
  EXPECT_FALSE(bus_->devices()[1].health.is_offline());
  EXPECT_EQ(bus_->counters().late_responses, 1U);
}

}  // namespace
}  // namespace mbgate::test
