// SPDX-License-Identifier: Apache-2.0
// Servers that close connections: idle ones, after each answer, or at once.
#include "bus_tcp_rig.hpp"
#include "unit/bus/queue/stop_axis.hpp"

namespace mbgate::test {
namespace {

class BusTcpClosing : public BusTcp {
 protected:
  void ask_and_answer(std::uint8_t unit = 1) {
    submit(job(kRead, unit));
    answer_last();
  }
  void answer_last() {
    const auto unit = static_cast<std::uint8_t>(units().back());
    answer(frames_.size() - 1, hex(std::vector{unit}) + "03 02 12 34");
  }
};

TEST_F(BusTcpClosing, AConnectionThatHasAnsweredIsOpenedAgainWhenSomebodyAsks) {
  open(tcp());
  ask_and_answer();
  advance(60s);
  close();
  EXPECT_EQ(next_deadline(), std::nullopt);
  EXPECT_TRUE(bus_->link().serves());
  EXPECT_EQ(opens_, 1U);
  submit(job(kRead));
  EXPECT_EQ(opens_, 2U);
  EXPECT_THAT(frames_, SizeIs(1));
  reopen();
  ASSERT_THAT(frames_, SizeIs(2));
  answer_last();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  EXPECT_EQ(bus_->counters().losses, 0U);
}

// Servers close what is idle.
TEST_F(BusTcpClosing, SoIsOneOnWhichNothingWasAsked) {
  open(tcp());
  advance(60s);
  close();
  EXPECT_EQ(next_deadline(), std::nullopt);
  EXPECT_TRUE(bus_->link().serves());
  submit(job(kRead));
  reopen();
  answer_last();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(bus_->counters().losses, 0U);
}

// The close was read when the bus wanted to look.
TEST_F(BusTcpClosing, TheNextOneIsLookedAtBeforeARequestToo) {
  open(tcp());
  advance(60s);
  EXPECT_TRUE(bus_->submit(job(kRead), now_));
  bus_->handle_lost(now_, bus::Loss::closed);
  while (bus_->poll()) {
  }
  reopen();
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(BusTcpClosing, OneOnWhichSomethingElseCameThanAnAnswerIsLost) {
  open(tcp());
  submit(job(kRead));
  line("7F FF 00 00 00 05 01 03 02 12 34");
  advance(60s);
  close();
  EXPECT_EQ(bus_->counters().losses, 1U);
}

TEST_F(BusTcpClosing, OneThatWasClosedAtOnceIsBackedOffFrom) {
  open(tcp());
  advance(10ms);
  close();
  EXPECT_EQ(bus_->counters().losses, 1U);
  EXPECT_NE(next_deadline(), std::nullopt);
}

TEST_F(BusTcpClosing, AReadThatACloseCutsIsAskedOnceMore) {
  open(tcp());
  ask_and_answer();
  bus::Job& read = job(kRead);
  submit(read);
  submit(job("06 0000 0001"));
  advance(90ms);
  close();
  EXPECT_EQ(opens_, 2U);
  reopen();
  EXPECT_THAT(units(), ElementsAre(1, 1, 1));
  answer_last();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  EXPECT_EQ(hex(read.transactions[0].response->bytes()), "03 02 12 34");
  EXPECT_EQ(frames_.back().substr(21, 2), "06");  // what waited behind it goes on
}

TEST_F(BusTcpClosing, AReadThatIsCutTwiceHasFailed) {
  open(tcp(2));
  ask_and_answer(2);
  submit(job(kRead, 1));
  close();
  reopen();
  ask_and_answer(2);
  close();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered, Ending::no_answer));
  EXPECT_EQ(next_deadline(), std::nullopt);
}

TEST_F(BusTcpClosing, EachPartOfAReadMayBeCutOnce) {
  open(tcp());
  bus::Job& parts = job(kRead);
  add(parts, "03 0001 0001");
  add(parts, "03 0002 0001");
  submit(parts);
  answer_last();
  for (int part = 1; part < 3; ++part) {
    advance(90ms);
    close();
    reopen();
    answer_last();
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_THAT(frames_, SizeIs(5));
}

TEST_F(BusTcpClosing, AWriteThatACloseCutsIsNotRepeated) {
  auto repeating = tcp();
  repeating.timing.retry_writes = true;
  repeating.timing.retries = 3;
  open(repeating);
  ask_and_answer();
  bus::Job& write = job("06 0000 0001");
  submit(write);
  close();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer));
  EXPECT_TRUE(write.was_on_wire);
  EXPECT_EQ(opens_, 1U);
}

TEST_F(BusTcpClosing, AStopThatACloseCutsIsRepeated) {
  const auto settings = tcp();
  open(settings, {axis(settings)});
  ask_and_answer();
  submit(job(kStop));
  close();
  EXPECT_THAT(endings_, SizeIs(1));
  reopen();
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2].substr(12), frames_[1].substr(12));
}

TEST_F(BusTcpClosing, ACutReadDoesNotOutliveItsDeadline) {
  open(tcp());
  ask_and_answer();
  bus::Job& read = job(kRead);
  read.deadline = now_ + 1s;
  submit(read);
  close();
  advance(999ms);
  EXPECT_THAT(endings_, SizeIs(1));
  advance(1ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::expired));
  EXPECT_TRUE(read.was_on_wire);
}

TEST_F(BusTcpClosing, WhatWaitsIsRefusedIfTheServerHasGone) {
  open(tcp());
  ask_and_answer();
  close();
  submit(job(kRead));
  bus_->handle_lost(now_);
  drain();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::closed));
  EXPECT_FALSE(bus_->link().serves());
  EXPECT_EQ(*next_deadline() - now_, 100ms);
  EXPECT_EQ(bus_->counters().losses, 1U);
}

TEST_F(BusTcpClosing, AConnectionThatDiesIsOpenedAgainAfterADelay) {
  open(tcp());
  ask_and_answer();
  bus_->handle_lost(now_);
  drain();
  EXPECT_FALSE(bus_->link().serves());
  EXPECT_EQ(*next_deadline() - now_, 100ms);
}

TEST_F(BusTcpClosing, AServerThatAcceptsAndClosesIsBackedOffFrom) {
  open(tcp());
  Duration delay = 100ms;
  for (int times = 0; times < 6; ++times) {
    submit(job(kRead));
    close();
    EXPECT_EQ(endings_.back(), Ending::closed);
    EXPECT_EQ(*next_deadline() - now_, delay);
    advance(delay);
    EXPECT_EQ(opens_, 2U + static_cast<unsigned>(times));
    delay *= 2;
    reopen();
  }
  ask_and_answer();
  close();
  submit(job(kRead));
  reopen();
  close();
  EXPECT_EQ(*next_deadline() - now_, 100ms);  // it has answered in between
}

TEST_F(BusTcpClosing, AnOfflineDeviceDoesNotOpenAConnection) {
  auto breaking = tcp();
  breaking.timing.offline_after = 1;
  open(breaking);
  ask_and_answer(2);
  submit(job(kRead));
  advance(100ms);
  close();
  submit(job(kRead));
  EXPECT_EQ(endings_.back(), Ending::offline);
  EXPECT_EQ(opens_, 1U);
}

TEST_F(BusTcpClosing, StoppingEndsWhatWasCut) {
  open(tcp());
  ask_and_answer();
  submit(job(kRead));
  close();
  bus_->stop(now_);
  drain();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::cancelled));
  reopen();
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusTcpClosing, WhileItStopsAStopIsRepeatedOnTheNextConnectionAndACutReadIsNot) {
  const auto settings = tcp();
  open(settings, {axis(settings)});
  ask_and_answer();
  submit(job(kRead));
  submit(job(kStop));
  bus_->stop(now_);
  close();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::cancelled));
  EXPECT_EQ(opens_, 2U);
  reopen();
  ASSERT_THAT(frames_, SizeIs(4));
  EXPECT_EQ(frames_[3].substr(21), "06 00 7C 00 E1");
}

TEST_F(BusTcpClosing, WhileItStopsAStopThatACloseCutsIsRepeatedAndNothingElseOpensAConnection) {
  const auto settings = tcp();
  open(settings, {axis(settings)});
  ask_and_answer();
  submit(job(kStop));
  bus_->stop(now_);
  close();
  reopen();
  ASSERT_THAT(frames_, SizeIs(3));
  answer(2, "01 06 00 7C 00 E1");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  close();
  EXPECT_EQ(opens_, 2U);
  EXPECT_EQ(next_deadline(), std::nullopt);
}

TEST_F(BusTcpClosing, AServerThatClosesAfterEachAnswerIsGivenTheTimeForIt) {
  open(tcp());
  ask_and_answer();
  submit(job("06 0000 0001"));
  close();
  EXPECT_EQ(endings_.back(), Ending::no_answer);  // nobody could know
  submit(job(kRead));
  reopen();
  submit(job("06 0000 0001", 2));
  answer_last();
  advance(20ms);
  EXPECT_THAT(frames_, SizeIs(3));
  close();
  reopen();
  EXPECT_THAT(units(), ElementsAre(1, 1, 1, 2));
}

TEST_F(BusTcpClosing, AServerThatStaysOpenAgainIsNotWaitedForTwice) {
  open(tcp());
  ask_and_answer();
  close();
  submit(job(kRead));
  reopen();
  answer_last();
  submit(job(kRead));
  EXPECT_EQ(until_next_frame(), bus::kTimeToClose);
  answer_last();
  submit(job(kRead));
  EXPECT_THAT(frames_, SizeIs(4));
}

}  // namespace
}  // namespace mbgate::test
