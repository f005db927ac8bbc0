// SPDX-License-Identifier: Apache-2.0
// Reads that are answered together.
#include "unit/bus/transmission/sharing_rig.hpp"

namespace mbgate::test {
namespace {

TEST_F(BusSharing, IdenticalWaitingReadsAreTransmittedOnce) {
  open(sharing());
  occupy();
  for (std::uint32_t source = 0; source < 32; ++source) {
    submit(job_of(source, kRead));
  }
  free_line();
  answer();
  EXPECT_THAT(endings_, SizeIs(32));
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(1));
  EXPECT_EQ(bus_->counters().shared_reads, 31U);
  for (std::size_t at = 1; at < jobs_.size(); ++at) {
    EXPECT_EQ(response_of(jobs_[at]), "03 02 12 34");
  }
}

TEST_F(BusSharing, CanBeTurnedOff) {
  let_two_wait(settings());
  answer();
  EXPECT_THAT(endings_, SizeIs(1));
}

TEST_F(BusSharing, NobodyJoinsAReadThatWasTransmitted) {
  open(sharing());
  submit(job_of(0, kRead));
  advance(10ms);
  submit(job_of(1, kRead));
  line(kAnswer);
  EXPECT_THAT(endings_, SizeIs(1));
  advance(10ms);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusSharing, NobodyJoinsAcrossAWriteThatWaitsBetweenThem) {
  let_two_wait_around(1);
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(frames_[1], "01 03 00 00 00 01 84 0A");
  answer();
  EXPECT_THAT(endings_, SizeIs(2));
}

TEST_F(BusSharing, ABroadcastIsAWriteToEveryDevice) {
  let_two_wait_around(0);
  answer();
  EXPECT_THAT(endings_, SizeIs(2));
}

TEST_F(BusSharing, AClientsOwnEarlierRequestsToTheDeviceGoFirst) {
  open(sharing());
  occupy();
  submit(job_of(0, kRead));
  submit(job_of(1, "03 0010 0001"));
  submit(job_of(1, kRead));
  free_line();
  answer();
  EXPECT_THAT(endings_, SizeIs(1));
}

TEST_F(BusSharing, TheOthersGoOnWhenTheOneThatLedHasGone) {
  auto retrying = sharing();
  retrying.timing.retries = 1;
  let_two_wait(retrying);
  jobs_[1].abandoned = true;
  advance(220ms);  // another device has answered: lost time is paid back
  EXPECT_THAT(frames_, SizeIs(2));
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled));
  EXPECT_EQ(bus_->counters().expired, 0U);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled, Ending::answered));
  EXPECT_EQ(response_of(jobs_[2]), "03 02 12 34");
}

TEST_F(BusSharing, EachKeepsItsOwnDeadline) {
  auto retrying = sharing();
  retrying.timing.retries = 1;
  let_two_wait(retrying);
  jobs_[2].deadline = now_ + 50ms;
  advance(110ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::expired));
  EXPECT_TRUE(jobs_[2].was_on_wire);
  EXPECT_EQ(bus_->counters().expired, 1U);
}

TEST_F(BusSharing, WhoLeavesBetweenTwoTriesIsNotCountedAsExpired) {
  auto retrying = sharing();
  retrying.timing.retries = 1;
  let_two_wait(retrying);
  jobs_[2].abandoned = true;
  advance(110ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled));
  EXPECT_EQ(bus_->counters().expired, 0U);
}

TEST_F(BusSharing, AllFailTogether) {
  let_two_wait(sharing());
  advance(110ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
  EXPECT_TRUE(jobs_[2].was_on_wire);
}

}  // namespace
}  // namespace mbgate::test
