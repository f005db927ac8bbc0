// SPDX-License-Identifier: Apache-2.0
// What is on the wire, the stops that wait and the order of turns, without a bus.
#include <gmock/gmock.h>

#include <deque>

#include "bus/queue/fairness.hpp"
#include "bus/queue/stop_lane.hpp"
#include "bus/transmission/transmission.hpp"
#include "support/hex.hpp"

namespace mbgate::test {
namespace {

using bus::Job;
using bus::JobClass;
using bus::LastSent;
using bus::StopLane;
using testing::ElementsAre;
using testing::IsEmpty;

class Transmissions : public testing::Test {
 protected:
  Job& lead(JobClass job_class, std::uint8_t address) {
    Job& job = jobs_.emplace_back();
    job.job_class = job_class;
    const auto pdu = modbus::Pdu::from(unhex("03 00 00 00 01"));
    job.transactions.push_back({address, *modbus::Request::parse(*pdu)});
    return job;
  }
  Job& fly(JobClass job_class, std::uint8_t address) {
    Job& job = lead(job_class, address);
    transmissions_.start(job);
    job.sent.in_flight = true;
    job.sent.tries = 1;
    return job;
  }

  std::deque<Job> jobs_;
  bus::Transmissions transmissions_{2};
};

TEST_F(Transmissions, HaveRoomForAsManyAsAreInFlight) {
  Job& first = fly(JobClass::read, 1);
  transmissions_.start(lead(JobClass::read, 2));
  EXPECT_TRUE(transmissions_.has_room());
  fly(JobClass::read, 3);
  EXPECT_FALSE(transmissions_.has_room());
  EXPECT_EQ(transmissions_.first_in_flight(), &first);
  EXPECT_EQ(&transmissions_.find(&first.transaction()), &first);
  first.sent.in_flight = false;
  EXPECT_TRUE(transmissions_.has_room());
}

TEST_F(Transmissions, GoOnBesideNoStopToTheirDevice) {
  Job& read = fly(JobClass::read, 1);
  EXPECT_FALSE(transmissions_.may_go_on(read));
  read.sent.in_flight = false;
  EXPECT_TRUE(transmissions_.may_go_on(read));
  fly(JobClass::stop, 2);
  EXPECT_TRUE(transmissions_.may_go_on(read));
  fly(JobClass::stop, 1);
  EXPECT_FALSE(transmissions_.may_go_on(read));
}

TEST_F(Transmissions, AreLedByTheirFirstFollowerWhenTheLeaderLeaves) {
  Job& gone = fly(JobClass::read, 1);
  gone.sent.in_flight = false;
  Job& next = lead(JobClass::read, 1);
  gone.sent.followers.push_back(&next);
  transmissions_.hand_over(gone);
  EXPECT_THAT(transmissions_.running(), ElementsAre(&next));
  EXPECT_EQ(next.sent.tries, 1U);
  EXPECT_THAT(next.sent.followers, IsEmpty());
  EXPECT_EQ(gone.sent.tries, 0U);
  EXPECT_THAT(gone.sent.followers, IsEmpty());
}

TEST_F(Transmissions, RunUntilTheyLeaveOrEnd) {
  Job& stop = fly(JobClass::stop, 1);
  stop.sent.in_flight = false;
  EXPECT_THAT(transmissions_.running(), ElementsAre(&stop));
  transmissions_.leave(stop);
  EXPECT_THAT(transmissions_.running(), IsEmpty());
  EXPECT_EQ(stop.sent.tries, 1U);
  transmissions_.end(stop);
  EXPECT_EQ(stop.sent.tries, 0U);
}

TEST_F(Transmissions, WaitInTheStopLaneInTheirOrder) {
  StopLane lane;
  const auto first_of = [&lane] { return lane.find([](const Job&) { return true; }); };
  Job& first = lead(JobClass::stop, 1);
  Job& second = lead(JobClass::stop, 2);
  lane.push(first);
  lane.push(second);
  EXPECT_EQ(first_of(), &first);
  EXPECT_EQ(lane.find([](const Job& it) { return it.address() == 2; }), &second);
  lane.remove(first);
  lane.push_front(first);
  EXPECT_EQ(first_of(), &first);
  EXPECT_EQ(lane.size(), 2U);
  lane.remove(first);
  lane.remove(second);
  EXPECT_EQ(first_of(), nullptr);
}

TEST(LastSent, CountsWritesSinceTheLastReadAndKnowsALastStop) {
  LastSent last;
  last.note(JobClass::read, 1);
  last.note(JobClass::write, 1);
  EXPECT_EQ(last.stop(), std::nullopt);
  last.note(JobClass::stop, 2);
  EXPECT_EQ(last.stop(), 2);
  EXPECT_EQ(last.writes_in_row(), 2U);
  last.note(JobClass::read, 2);
  EXPECT_EQ(last.stop(), std::nullopt);
  EXPECT_EQ(last.writes_in_row(), 0U);
}

}  // namespace
}  // namespace mbgate::test
