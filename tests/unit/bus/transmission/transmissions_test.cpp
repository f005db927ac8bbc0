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
using bus::Transmission;
using testing::ElementsAre;
using testing::IsEmpty;

class Transmissions : public testing::Test {
 protected:
  Transmission& lead(JobClass job_class, std::uint8_t address) {
    Job& job = jobs_.emplace_back();
    job.job_class = job_class;
    const auto pdu = modbus::Pdu::from(unhex("03 00 00 00 01"));
    job.transactions.push_back({address, *modbus::Request::parse(*pdu)});
    return transmissions_.lead(job);
  }
  Transmission& fly(JobClass job_class, std::uint8_t address) {
    Transmission& transmission = lead(job_class, address);
    transmissions_.start(transmission);
    transmission.in_flight = true;
    transmission.tries = 1;
    return transmission;
  }

  std::deque<Job> jobs_;
  bus::Transmissions transmissions_{2};
};

TEST_F(Transmissions, HaveRoomForAsManyAsAreInFlight) {
  Transmission& first = fly(JobClass::read, 1);
  transmissions_.start(lead(JobClass::read, 2));
  EXPECT_TRUE(transmissions_.has_room());
  fly(JobClass::read, 3);
  EXPECT_FALSE(transmissions_.has_room());
  EXPECT_EQ(transmissions_.first_in_flight(), &first);
  EXPECT_EQ(&transmissions_.find(&first.on_wire()), &first);
  first.in_flight = false;
  EXPECT_TRUE(transmissions_.has_room());
}

TEST_F(Transmissions, GoOnBesideNoStopToTheirDevice) {
  Transmission& read = fly(JobClass::read, 1);
  EXPECT_FALSE(transmissions_.may_go_on(read));
  read.in_flight = false;
  EXPECT_TRUE(transmissions_.may_go_on(read));
  fly(JobClass::stop, 2);
  EXPECT_TRUE(transmissions_.may_go_on(read));
  fly(JobClass::stop, 1);
  EXPECT_FALSE(transmissions_.may_go_on(read));
}

TEST_F(Transmissions, AreLedByTheirFirstFollowerWhenTheLeaderLeaves) {
  Transmission& read = lead(JobClass::read, 1);
  transmissions_.start(read);
  Job& gone = *read.leader;
  Job& next = jobs_.emplace_back();
  read.followers.push_back(&next);
  bus::Transmissions::hand_over(read);
  EXPECT_EQ(read.leader, &next);
  EXPECT_EQ(next.leads, &read);
  EXPECT_EQ(gone.leads, nullptr);
  EXPECT_THAT(read.followers, IsEmpty());
}

TEST_F(Transmissions, RunUntilTheyLeaveOrEnd) {
  Transmission& stop = lead(JobClass::stop, 1);
  transmissions_.start(stop);
  EXPECT_THAT(transmissions_.running(), ElementsAre(&stop));
  transmissions_.leave(stop);
  EXPECT_THAT(transmissions_.running(), IsEmpty());
  Job& job = *stop.leader;
  EXPECT_EQ(job.leads, &stop);
  transmissions_.end(stop);
  EXPECT_EQ(job.leads, nullptr);
}

TEST_F(Transmissions, WaitInTheStopLaneInTheirOrder) {
  StopLane lane;
  const auto first_of = [&lane] { return lane.find([](const Transmission&) { return true; }); };
  Transmission& first = lead(JobClass::stop, 1);
  Transmission& second = lead(JobClass::stop, 2);
  lane.push(first);
  lane.push(second);
  EXPECT_EQ(first_of(), &first);
  EXPECT_EQ(lane.find([](const Transmission& it) { return it.leader->address() == 2; }), &second);
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
