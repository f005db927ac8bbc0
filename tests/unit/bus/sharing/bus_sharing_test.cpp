// SPDX-License-Identifier: Apache-2.0
// Reads that are answered together.
#include "bus/sharing/shared_read.hpp"
#include "unit/bus/sharing/sharing_rig.hpp"

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

TEST_F(BusSharing, AdjacentAndOverlappingReadsAreMerged) {
  open(sharing(true));
  occupy();
  submit(job_of(0, "03 0000 0002"));
  submit(job_of(1, "03 0004 0001"));
  submit(job_of(2, "03 0001 0003"));
  submit(job_of(3, "03 0006 0001"));  // 5 lies between
  free_line();
  EXPECT_THAT(frames_, ElementsAre("01 03 00 00 00 05 85 C9"));
  advance(10ms);
  const auto answer =
      modbus::encode_rtu(1, *modbus::Pdu::from(unhex("03 0A 0000 0001 0002 0003 0004")));
  bus_->handle_bytes({answer.data(), answer.size()}, now_);
  drain();
  EXPECT_THAT(endings_, SizeIs(3));
  EXPECT_EQ(response_of(jobs_[1]), "03 04 00 00 00 01");
  EXPECT_EQ(response_of(jobs_[2]), "03 02 00 04");
  EXPECT_EQ(response_of(jobs_[3]), "03 06 00 01 00 02 00 03");
  EXPECT_EQ(bus_->counters().merged_reads, 2U);
}

TEST_F(BusSharing, AReadWithinTheOneThatLeadsGetsItsPart) {
  open(sharing(true));
  occupy();
  submit(job_of(0, "03 0000 0002"));
  submit(job_of(1, "03 0001 0001"));
  free_line();
  advance(10ms);
  line("01 03 04 00 07 12 34 46 85");
  ASSERT_THAT(endings_, SizeIs(2));
  EXPECT_EQ(response_of(jobs_[1]), "03 04 00 07 12 34");
  EXPECT_EQ(response_of(jobs_[2]), "03 02 12 34");
}

TEST_F(BusSharing, MergingKeepsToLimitsGroupsWindowsValuesAndWhatMayBeRead) {
  drive::Device device{"axis", {}, 1, settings().timing};
  device.profile.limits.read[2] = 4;
  device.profile.groups = {{modbus::Table::holding_registers, 0, 16},
                           {modbus::Table::holding_registers, 16, 16}};
  device.profile.write_only = {{modbus::Table::holding_registers, 9, 1}};
  device.profile.values.add({modbus::Table::holding_registers, 31, 2});
  const auto merges = [&](std::string_view one, std::string_view other, std::uint32_t window = 0) {
    bus::BusQueue queue(10);
    bus::Job leader;
    bus::Job follower;
    add(leader, one);
    add(follower, other);
    follower.transactions[0].window_begin = window;
    EXPECT_TRUE(queue.push(follower));
    bus::Transmission transmission;
    transmission.leader = &leader;
    bus::gather_followers(queue, transmission, device, {false, true});
    const bool merged = !follower.is_waiting();
    if (!merged) {
      queue.remove(follower);
    }
    return merged;
  };
  EXPECT_TRUE(merges("03 0000 0002", "03 0002 0002"));
  EXPECT_FALSE(merges("03 0000 0003", "03 0003 0002"));     // over the limit
  EXPECT_FALSE(merges("03 000E 0002", "03 0010 0001"));     // across a group
  EXPECT_FALSE(merges("03 0008 0001", "03 0009 0001"));     // write-only
  EXPECT_FALSE(merges("03 001E 0001", "03 001F 0001"));     // through a value
  EXPECT_FALSE(merges("03 0000 0002", "03 0002 0002", 1));  // of another window
  EXPECT_FALSE(merges("03 0000 0002", "04 0002 0002"));     // of another table
  EXPECT_FALSE(merges("03 0000 0001", "03 0002 0001"));     // with something between
}

TEST_F(BusSharing, IfTheMergedReadFailsItsPartsGoOneByOne) {
  open(sharing(true));
  occupy();
  submit(job_of(0, kRead));
  submit(job_of(1, "03 0001 0001"));
  free_line();
  EXPECT_THAT(frames_, SizeIs(1));
  advance(10ms);
  line("01 83 02 C0 F1");
  advance(10ms);
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(frames_[1], "01 03 00 01 00 01 D5 CA");
  line("01 83 02 C0 F1");
  advance(50ms);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2], "01 03 00 00 00 01 84 0A");
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  EXPECT_EQ(response_of(jobs_[1]), "03 02 12 34");
  EXPECT_EQ(response_of(jobs_[2]), "83 02");
}

TEST_F(BusSharing, AMergedReadThatWasRefusedIsNotMergedAgainUntilItsDeviceWasOffline) {
  auto breaking = sharing(true);
  breaking.timing.offline_after = 1;
  open(breaking);
  const auto first_of_two = [&] {
    occupy();
    submit(job_of(0, kRead));
    submit(job_of(1, "03 0001 0001"));
    frames_.clear();
    line(kStranger);
    advance(5ms);
    return frames_.empty() ? "none" : frames_[0];
  };
  const auto refuse = [&](int count) {
    for (int times = 0; times < count; ++times) {
      advance(50ms);
      line("01 83 02 C0 F1");
    }
    advance(50ms);
  };
  EXPECT_EQ(first_of_two(), "01 03 00 00 00 02 C4 0B");
  refuse(3);  // the merged one, and its parts
  EXPECT_EQ(first_of_two(), "01 03 00 00 00 01 84 0A");
  refuse(2);
  update(breaking, {});
  EXPECT_EQ(first_of_two(), "01 03 00 00 00 02 C4 0B");
  refuse(3);  // the merged one, and its parts
  submit(job(kRead));
  advance(3s);
  EXPECT_TRUE(bus_->devices()[1].health.is_offline());
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  advance(3s);
  EXPECT_EQ(first_of_two(), "01 03 00 00 00 02 C4 0B");
}

TEST_F(BusSharing, WhileItStopsTheFailedMergedReadIsNotSentInParts) {
  for (const bool refused : {true, false}) {
    frames_.clear();
    endings_.clear();
    open(sharing(true));
    occupy();
    submit(job_of(0, kRead));
    submit(job_of(1, "03 0001 0001"));
    free_line();
    bus_->stop(now_);
    drain();
    advance(10ms);
    if (refused) {
      line("01 83 02 C0 F1");
    }
    advance(1s);
    EXPECT_THAT(frames_, SizeIs(1)) << refused;
    EXPECT_THAT(endings_, ElementsAre(Ending::cancelled, Ending::cancelled)) << refused;
  }
}

}  // namespace
}  // namespace mbgate::test
