// SPDX-License-Identifier: Apache-2.0
// What becomes of jobs on a bus: retries, echo, deadlines, loss of the line.
#include "bus_rig.hpp"

namespace mbgate::test {
namespace {

TEST_F(Bus, ABadCrcIsRetriedForReadsOnly) {
  open_retrying();
  submit(job(kRead));
  advance(10ms);
  line("01 03 02 12 35 B5 33");
  advance(30ms);
  EXPECT_THAT(frames_, SizeIs(2));
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(200ms);  // its quarantine
  submit(job("06 0000 0001"));
  advance(10ms);
  line("01 06 00 00 00 02 48 0A");
  advance(30ms);
  EXPECT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(endings_.back(), Ending::no_answer);
  EXPECT_EQ(bus_->counters().bad_crcs, 2U);
}

// What is damaged may be one of two answers, and the other may still be on its way.
TEST_F(Bus, AReadIsRepeatedAfterABadCrcWhenAnotherAnswerWouldHaveCome) {
  open_retrying();
  submit(job(kRead));
  advance(70ms);
  line(kAnswer);
  advance(30ms);
  submit(job(kRead));
  advance(10ms);
  line("01 03 02 12 35 B5 33");
  advance(70ms);  // 20 ms of silence show that it is damaged
  EXPECT_THAT(frames_, SizeIs(2));
  advance(20ms);
  EXPECT_THAT(frames_, SizeIs(3));
}

TEST_F(Bus, LooksAtItsLineOnceBeforeItTransmits) {
  open(settings());
  EXPECT_TRUE(bus_->submit(job(kRead), now_));
  EXPECT_TRUE(bus_->submit(job(kOther), now_));
  ASSERT_TRUE(bus_->poll());
  EXPECT_FALSE(bus_->poll());
  bus_->handle_looked(now_);
  drain();
  EXPECT_THAT(frames_, ElementsAre(kReadFrame));
}

TEST_F(Bus, LooksAgainOnAnotherConnection) {
  open(settings());
  EXPECT_TRUE(bus_->submit(job(kRead), now_));
  bus_->handle_lost(now_);  // before it has looked
  while (bus_->poll()) {
  }
  advance(1s);
  bus_->handle_opened(now_);
  submit(job(kRead));
  advance(1s);
  EXPECT_THAT(frames_, ElementsAre(kReadFrame));
}

TEST_F(Bus, HalfALateAnswerDoesNotGoOnOnAnotherConnection) {
  open(settings());
  submit(job(kRead));
  time_out();
  line("01 03 02");
  bus_->handle_lost(now_);
  drain();
  bus_->handle_opened(now_);
  drain();
  line("12 34 B5 33");
  advance(50ms);
  EXPECT_EQ(bus_->counters().late_responses, 0U);
}

TEST_F(Bus, ADeviceIsSilentSinceItsTimeoutThoughThatIsSeenLater) {
  open(settings());
  submit(job(kRead));
  const Instant due = now_ + kEmission + 100ms;
  now_ = due + 30ms;
  bus_->handle_deadline(now_);
  drain();
  EXPECT_EQ(bus_->devices()[1].health.state_since(), due);
}

TEST_F(Bus, ReadsAndComparesItsEcho) {
  auto echoing = settings();
  echoing.line.echo = true;
  open(echoing);
  submit(job(kRead));
  EXPECT_THAT(frames_, ElementsAre("01 03 00 00 00 01 84 0A"));
  line("01 03 00 00");
  line("00 01 84 0A 01 03 02 12 34 B5 33");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(20ms);
  submit(job("06 0000 0001"));  // its answer looks like its echo
  line("01 06 00 00 00 01 48 0A");
  EXPECT_THAT(endings_, SizeIs(1));
  line("01 06 00 00 00 01 48 0A");
  EXPECT_THAT(endings_, SizeIs(2));
  EXPECT_EQ(bus_->counters().echo_mismatches, 0U);
}

TEST_F(Bus, AnEchoThatDiffersIsCountedAndNotTakenForAnAnswer) {
  auto echoing = settings();
  echoing.line.echo = true;
  open(echoing);
  submit(job(kRead));
  line(kAnswer);
  EXPECT_THAT(endings_, IsEmpty());
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(bus_->counters().echo_mismatches, 1U);
  EXPECT_EQ(bus_->counters().late_responses, 0U);
}

TEST_F(Bus, FramesAreHeardAgainAfterAnEchoThatDiffered) {
  auto echoing = settings();
  echoing.line.echo = true;
  open(echoing);
  submit(job(kRead));
  line("FF");
  advance(150ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  line(kAnswer);
  EXPECT_EQ(bus_->counters().late_responses, 1U);
}

TEST_F(Bus, AnEchoIsNoAnswerEvenIfNoiseCameBeforeIt) {
  auto echoing = settings();
  echoing.line.echo = true;
  open(echoing);
  submit(job("06 0010 0005"));
  line("FF");
  advance(1ms);
  line("01 06 00 10 00 05 48 0C");
  EXPECT_THAT(endings_, IsEmpty());
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(Bus, SilenceThatWasAskedForIsNoTimeout) {
  auto settling = settings();
  settling.settle = 50ms;
  open(settling);
  bus::Job& listen_only = job("08 0004 0000");
  listen_only.transactions[0].silence_is_success = true;
  submit(listen_only);
  submit(job(kRead, 2));
  time_out();
  EXPECT_THAT(endings_, ElementsAre(Ending::transmitted));
  EXPECT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(bus_->counters().timeouts, 0U);
}

TEST_F(Bus, ABadCrcIsNoSilence) {
  open(settings());
  submit(job(kRead));
  advance(10ms);
  line("01 03 02 12 35 B5 33");
  advance(30ms);
  EXPECT_EQ(bus_->devices()[1].counters.bad_crcs, 1U);
  EXPECT_EQ(bus_->devices()[1].health.unanswered_in_row(), 0U);
}

TEST_F(Bus, ALineThatDiesAtOnceIsReopenedLessAndLessOften) {
  open(settings());
  std::vector<Duration> waits;
  for (int times = 0; times < 4; ++times) {
    bus_->handle_lost(now_);
    waits.push_back(*next_deadline() - now_);
    advance(waits.back());
    bus_->handle_opened(now_);
  }
  EXPECT_THAT(waits, ElementsAre(100ms, 200ms, 400ms, 800ms));
  advance(5s);
  bus_->handle_lost(now_);
  EXPECT_EQ(*next_deadline() - now_, 100ms);
}

TEST_F(Bus, LetsNothingComeBetweenTheTransactionsOfAJob) {
  open(settings());
  bus::Job& two = job(kRead);
  add(two, "03 0001 0001");
  submit(two);
  bus::Job& other = job(kRead, 9);
  other.source = bus::FairnessKey{1};
  submit(other);
  advance(10ms);
  line(kAnswer);
  advance(10ms);
  EXPECT_THAT(frames_, ElementsAre("01 03 00 00 00 01 84 0A", "01 03 00 01 00 01 D5 CA"));
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_TRUE(two.transactions[0].response && two.transactions[1].response);
}

TEST_F(Bus, AnExceptionEndsAJobOfSeveralTransactions) {
  open(settings());
  bus::Job& two = job(kRead);
  add(two, "03 0001 0001");
  submit(two);
  line("01 83 02 C0 F1");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(hex(two.transactions[0].response->bytes()), "83 02");
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(Bus, NoRetryBeginsAfterTheDeadline) {
  auto retrying = settings();
  retrying.timing.retries = 5;
  open(retrying);
  bus::Job& read = job(kRead);
  read.deadline = now_ + 150ms;
  submit(read);
  advance(10s);
  EXPECT_THAT(frames_, SizeIs(2));
  EXPECT_THAT(endings_, ElementsAre(Ending::expired));
  EXPECT_TRUE(read.was_on_wire);
}

// The check is the gateway's own; of what the client has asked for, nothing has begun.
TEST_F(Bus, AWriteDoesNotFollowItsCheckAfterItsDeadline) {
  const std::vector<std::uint16_t> stated{0x1234};
  open(settings());
  bus::Job& write = job(kRead);
  write.transactions.front().must_hold = &stated;
  add(write, "06 0001 0001");
  write.deadline = now_ + 15ms;
  submit(write);
  advance(20ms);
  line(kAnswer);
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(1));
  EXPECT_THAT(endings_, ElementsAre(Ending::expired));
}

TEST_F(Bus, WaitingJobsExpireAtTheirDeadlineToo) {
  open(settings());
  submit(job(kRead));
  bus::Job& waiting = job(kRead, 2);
  waiting.deadline = now_ + 20ms;
  submit(waiting);
  const Instant start = now_;
  advance(50ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::expired));
  EXPECT_EQ(ended_at_[0] - start, 20ms);
  EXPECT_FALSE(waiting.was_on_wire);
}

TEST_F(Bus, WhatIsGivenUpOnTheWireIsNotWaitedFor) {
  open(settings());
  submit(job(kRead));
  bus_->stop(now_);
  bus_->give_up(now_);
  drain();
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  advance(1s);
  EXPECT_EQ(bus_->counters().timeouts, 0U);
}

TEST_F(Bus, CountsWhatADeviceDid) {
  open(settings());
  submit(job(kRead));
  advance(11s);  // nothing is owed any more
  submit(job(kRead));
  line("01 83 02 C0 F1");
  const auto& counters = bus_->devices()[1].counters;
  EXPECT_EQ(counters.transmissions, 2U);
  EXPECT_EQ(counters.timeouts, 1U);
  EXPECT_EQ(counters.responses, 1U);
  EXPECT_EQ(counters.exceptions, 1U);
  EXPECT_EQ(bus_->devices()[1].health.unanswered_in_row(), 0U);
}

}  // namespace
}  // namespace mbgate::test
