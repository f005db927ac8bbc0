// SPDX-License-Identifier: Apache-2.0
// Stops on a line that is not open, lines behind `tcp://` that the far end closes, and what a stop
// has cut short.
#include "stop_axis.hpp"
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test::bus_closed_line_test {
namespace {

class BusClosedLine : public Bus {
 protected:
  void lose(bus::Loss loss = bus::Loss::failed) {
    bus_->handle_lost(now_, loss);
    drain();
  }
  void reopen() {
    bus_->handle_opened(now_);
    drain();
    advance(5ms);
  }
  /// The next attempt is seconds away.
  void lose_for_long() {
    open(settings(), {axis(settings())});
    for (int times = 0; times < 6; ++times) {
      lose();
      advance(5s);
    }
    lose();
    advance(1s);
    opens_ = 0;
  }
  static bus::BusSettings remote() {
    auto remote = settings();
    remote.line.remote.emplace();
    return remote;
  }
};

TEST_F(BusClosedLine, AStopHasItOpenedAtOnce) {
  lose_for_long();
  submit(job(kRead));
  EXPECT_THAT(endings_, ElementsAre(Ending::closed));
  EXPECT_EQ(opens_, 0U);
  submit(job(kStop));
  advance(0ms);
  EXPECT_EQ(opens_, 1U);
  reopen();
  EXPECT_THAT(frames_, ElementsAre(kStopFrame));
}

TEST_F(BusClosedLine, AStopWaitsForTheNextAttemptToo) {
  lose_for_long();
  submit(job(kStop));
  advance(1ms);
  ASSERT_EQ(opens_, 1U);
  submit(job_of(1, "06 007D 00E1"));
  EXPECT_THAT(endings_, ElementsAre(Ending::closed)) << "a write";
  lose();
  advance(200ms);
  EXPECT_EQ(opens_, 2U);
  reopen();
  EXPECT_THAT(frames_, ElementsAre(kStopFrame));
}

// An adapter that its bus has reset is back after a second or so.
TEST_F(BusClosedLine, AStopThatTheLossHasCutIsSentAgainOnceItIsBack) {
  open(settings(), {axis(settings())});
  submit(job(kStop));
  advance(3ms);
  lose();
  advance(1ms);
  lose();  // there is no port
  advance(1200ms);
  frames_.clear();
  reopen();
  EXPECT_THAT(frames_, ElementsAre(kStopFrame));
}

TEST_F(BusClosedLine, AStopEndsIfAllAttemptsFailWhichAreNoMoreOftenThanReopenMin) {
  lose_for_long();
  submit(job(kStop));
  advance(0ms);
  for (unsigned attempts = 1; attempts <= 20; ++attempts) {
    EXPECT_EQ(opens_, attempts);
    EXPECT_THAT(endings_, IsEmpty());
    lose();
    advance(99ms);
    EXPECT_EQ(opens_, attempts);
    advance(1ms);
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::closed));
}

TEST_F(BusClosedLine, AStopEndsIfNobodyKnowsWhetherThatFailsInTime) {
  lose_for_long();
  submit(job(kStop));
  advance(1999ms);
  EXPECT_THAT(endings_, IsEmpty());
  advance(1ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::closed));
}

// Only the time counts in which the line was not open.
TEST_F(BusClosedLine, AStopThatWaitedBeforeHasItOpenedToo) {
  auto slow = remote();
  slow.timing.response_timeout = 3s;
  slow.stop_wait = 3s;
  open(slow, {axis(slow)});
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  submit(job(kRead));
  submit(job(kStop));
  advance(2500ms);
  lose(bus::Loss::closed);
  EXPECT_EQ(opens_, 2U);
  reopen();
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusClosedLine, IsNotOpenedAgainWhileTheGatewayStops) {
  open(settings(), {axis(settings())});
  lose();
  bus_->stop(now_);
  drain();
  opens_ = 0;
  advance(10s);
  EXPECT_EQ(opens_, 0U);
}

TEST_F(BusClosedLine, AStopWaitsNoLongerForALineThatRested) {
  open(remote(), {axis(remote())});
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  lose(bus::Loss::closed);
  submit(job(kStop));
  ASSERT_EQ(opens_, 2U);
  advance(1999ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(1ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::closed));
}

TEST_F(BusClosedLine, AStopThatWaitedWhenTheLineWasLostIsSentOnTheNext) {
  auto slow = settings();
  slow.timing.response_timeout = 1s;
  open(slow, {axis(slow)});
  submit(job(kRead, 2));
  advance(20ms);
  submit(job_of(1, kStop));
  lose();
  EXPECT_THAT(endings_, ElementsAre(Ending::closed));  // the read
  advance(100ms);
  EXPECT_EQ(opens_, 2U);
  reopen();
  advance(1ms);
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusClosedLine, OneBehindTcpThatHasAnsweredIsOpenedAgainWhenSomebodyAsks) {
  open(remote());
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  lose(bus::Loss::closed);
  advance(10s);
  EXPECT_EQ(opens_, 1U);
  EXPECT_EQ(bus_->counters().losses, 0U);
  submit(job(kRead));
  EXPECT_EQ(opens_, 2U);
  reopen();
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusClosedLine, OneBehindTcpThatWasAskedAndHasNotAnsweredIsLost) {
  open(remote());
  submit(job(kRead));
  advance(10ms);
  lose(bus::Loss::closed);
  EXPECT_EQ(bus_->counters().losses, 1U);
  EXPECT_THAT(endings_, ElementsAre(Ending::closed));
  lose(bus::Loss::failed);  // an attempt to open it again
  EXPECT_EQ(bus_->counters().losses, 1U);
}

TEST_F(BusClosedLine, AReadThatWasOnTheWireThereIsAskedOnceMoreAndAWriteIsNot) {
  for (const bool is_read : {true, false}) {
    frames_.clear();
    endings_.clear();
    open(remote());
    submit(job(kRead));
    advance(10ms);
    line(kAnswer);
    submit(is_read ? job(kRead) : job(kMove));
    advance(10ms);
    lose(bus::Loss::closed);
    reopen();
    advance(300ms);  // what is owed may come first
    EXPECT_THAT(frames_, SizeIs(is_read ? 3 : 2));
    line(kAnswer);
    EXPECT_THAT(endings_,
                ElementsAre(Ending::answered, is_read ? Ending::answered : Ending::no_answer));
  }
}

// Connecting may take longer than that.
TEST_F(BusClosedLine, AStopWaitsForALineThatIsBeingReopenedUntilItsDeadline) {
  auto hanging = remote();
  hanging.hung_after = 1s;
  hanging.hung_requests = 2;
  open(hanging, {axis(hanging, 2)});
  for (int times = 0; times < 12; ++times) {
    submit(job(kRead));
    advance(300ms);
  }
  ASSERT_TRUE(bus_->link().is_reopening());
  endings_.clear();
  submit(job(kStop, 2));
  advance(1999ms);
  EXPECT_THAT(endings_, IsEmpty());
  advance(1ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::closed));
}

TEST_F(BusClosedLine, WhatAStopCutsShortIsNeitherAnsweredNorUnanswered) {
  auto slow = settings();
  slow.timing.response_timeout = 1s;
  slow.timing.offline_after = 1;
  open(slow, {axis(slow), axis(slow, 2)});
  submit(job(kRead, 2));
  advance(20ms);
  submit(job_of(1, kStop));
  advance(200ms);
  EXPECT_EQ(frames_.back(), kStopFrame);
  EXPECT_FALSE(bus_->devices()[2].health.is_offline());
  EXPECT_GT(bus_->parts().held_back(2, now_), 0ms);  // it stays open
}

}  // namespace
}  // namespace mbgate::test::bus_closed_line_test
