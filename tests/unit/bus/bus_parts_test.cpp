// SPDX-License-Identifier: Apache-2.0
// Requests that go to their device in several parts, and their deadline.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

using BusParts = Bus;

TEST_F(BusParts, ARunOfWhichAPartWasDoneIsFinishedAfterItsDeadline) {
  open(settings());
  bus::Job& run = job("06 0000 0001");
  add(run, "06 0001 0001");
  add(run, "06 0002 0001");
  run.deadline = now_ + 15ms;
  submit(run);
  for (std::size_t part = 1; part <= 3; ++part) {
    ASSERT_THAT(frames_, SizeIs(part));
    advance(20ms);
    line(frames_.back());
    advance(kT35);
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(bus_->counters().expired, 0U);
}

// The device may owe more answers than were counted, and is left alone for as long.
TEST_F(BusParts, ARunThatIsHeldBackBeyondItsDeadlineEndsThere) {
  open(settings());
  submit(job("06 0000 0007"));
  advance(5s);
  endings_.clear();
  bus::Job& run = job("06 0000 0001");
  add(run, "06 0001 0001");
  run.deadline = now_ + 1s;
  submit(run);
  advance(10ms);
  line(frames_.back());
  advance(988ms);
  EXPECT_THAT(endings_, IsEmpty());
  advance(10ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::expired));
  advance(20s);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusParts, ReadsInPartsThatHaveBegunAreFinishedAfterTheirDeadline) {
  auto slow = settings();
  slow.timing.gap = 10s;
  open(slow);
  advance(10s);
  bus::Job& both = job(kRead);
  add(both, "03 0001 0001");
  both.deadline = now_ + 1s;
  submit(both);
  advance(10ms);
  line(kAnswer);
  advance(10020ms);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusParts, NoPartOfARunIsRepeatedAfterItsDeadline) {
  auto retrying = settings();
  retrying.timing.retries = 5;
  open(retrying);
  bus::Job& run = job(kRead);
  add(run, "03 0001 0001");
  run.deadline = now_ + 150ms;
  submit(run);
  advance(10ms);
  line(kAnswer);
  advance(10s);
  EXPECT_THAT(frames_, SizeIs(3));  // both parts, and one of them again
  EXPECT_THAT(endings_, ElementsAre(Ending::expired));
  EXPECT_EQ(bus_->counters().expired, 1U);
}

}  // namespace
}  // namespace mbgate::test
