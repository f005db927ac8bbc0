// SPDX-License-Identifier: Apache-2.0
// A stop waits for no answer that is owed, so an owed answer may come in place of its own: which of
// them say that it was done.
#include "unit/bus/bus_rig.hpp"
#include "unit/bus/queue/stop_axis.hpp"

namespace mbgate::test {
namespace {

constexpr auto kMoveBy16 = "10 007C 0001 02 0066";
constexpr auto kAnswerBy16 = "01 10 00 7C 00 01 C0 11";  // to either: it names no value
constexpr auto kUnanswered = 110ms;  // such a frame takes 6.3 ms, the response timeout is 100 ms

class BusStopAnswers : public Bus {
 protected:
  void open_axis() {
    auto other_times = settings();
    other_times.timing.stop_retries = 1;
    other_times.turnaround = 10ms;
    other_times.line.echo = false;
    open(other_times, {axis(other_times)});
  }
  /// The first belongs to a move that was not answered.
  void expect_that_only_the_second_answer_is_the_stops() {
    advance(10ms);
    line(kAnswerBy16);
    EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
    advance(10ms);
    line(kAnswerBy16);
    EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
  }
  /// The stop is repeated and answered once by an axis that is known to be fast, so that its other
  /// answer may still come.
  void open_with_stop_answered_once() {
    open_axis();
    submit(job_of(1, kRead));
    advance(10ms);
    line(kAnswer);
    advance(10ms);
    endings_.clear();
    frames_.clear();
    frame_times_.clear();
    submit(job(kStop));
    time_out();
    advance(10ms);
    line(kStopFrame);
  }
};

TEST_F(BusStopAnswers, TheLateAnswerToAMoveThatLooksTheSameIsNone) {
  open_axis();
  submit(job_of(1, kMoveBy16));
  advance(kUnanswered);
  submit(job(kStopBy16));
  ASSERT_THAT(frames_, SizeIs(2));
  advance(10ms);
  line(kAnswerBy16);  // of the move
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  advance(10ms);
  line(kAnswerBy16);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
}

// The tail of the move is over, and nothing has been waited for: a stop is no probe.
TEST_F(BusStopAnswers, TheLateAnswerToAMoveOfAnOfflineAxisIsNone) {
  auto short_tails = settings();
  short_tails.timing.offline_after = 1;
  short_tails.timing.quarantine = 10ms;
  short_tails.line.echo = false;
  open(short_tails, {axis(short_tails)});
  submit(job_of(1, kMoveBy16));
  advance(kUnanswered + 100ms);
  submit(job(kStopBy16));
  ASSERT_THAT(frames_, SizeIs(2));
  expect_that_only_the_second_answer_is_the_stops();
}

// Each of them would leave the drive alone for ten seconds, once it is back.
TEST_F(BusStopAnswers, WhatIsStoppedAgainAndAgainOwesOneAnswerForIt) {
  auto short_tails = settings();
  short_tails.timing.offline_after = 1;
  short_tails.timing.quarantine = 10ms;
  short_tails.timing.stop_retries = 0;
  short_tails.line.echo = false;
  open(short_tails, {axis(short_tails)});
  for (unsigned stops = 0; stops < 4; ++stops) {
    submit(job(kStop));
    advance(kUnanswered + 400ms);
  }
  submit(job(kStop));
  advance(10ms);
  line(kStopFrame);
  EXPECT_EQ(endings_.back(), Ending::answered);
  const std::size_t stops = frames_.size();
  submit(job_of(1, kMove));
  advance(300ms);
  EXPECT_EQ(frames_.size(), stops + 1);
}

// Two drives at one address, or a repeater: a stop does not wait until both have answered.
TEST_F(BusStopAnswers, TheSecondAnswerToAMoveThatLooksTheSameIsNone) {
  open_axis();
  for (int times = 0; times < 2; ++times) {
    submit(job_of(1, kMoveBy16));
    advance(10ms);
    line(kAnswerBy16);
    advance(10ms);
    line(kAnswerBy16);
    advance(kUnanswered);
  }
  submit(job_of(1, kMoveBy16));
  advance(10ms);
  line(kAnswerBy16);
  submit(job(kStopBy16));
  advance(10ms);
  ASSERT_THAT(frames_, SizeIs(4));
  line(kAnswerBy16);  // of the move
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered, Ending::answered));
  advance(10ms);
  line(kAnswerBy16);
  EXPECT_THAT(endings_, SizeIs(4));
  EXPECT_EQ(endings_.back(), Ending::answered);
}

TEST_F(BusStopAnswers, ALateExceptionToTheTryBeforeIsNone) {
  open_axis();
  submit(job(kStop));
  time_out();
  advance(10ms);
  ASSERT_THAT(frames_, SizeIs(2));
  line("01 86 04 43 A3");
  EXPECT_THAT(endings_, IsEmpty());
  advance(10ms);
  line(kStopFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

// Nobody can tell whether the one answer was the move's: the stop is repeated.
TEST_F(BusStopAnswers, WhereTheMoveIsNeverAnsweredARepetitionShowsIt) {
  open_axis();
  submit(job_of(1, kMoveBy16));
  advance(kUnanswered);
  submit(job(kStopBy16));
  advance(10ms);
  line(kAnswerBy16);
  advance(kUnanswered);
  ASSERT_THAT(frames_, SizeIs(3));
  advance(10ms);
  line(kAnswerBy16);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
}

TEST_F(BusStopAnswers, ThatToTheSameStopBeforeIsOne) {
  open_axis();
  submit(job(kStop));
  time_out();
  ASSERT_THAT(frames_, SizeIs(2));
  advance(10ms);
  line(kStopFrame);  // of the first transmission or of the second one
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

// The write between may have set the axis in motion again.
TEST_F(BusStopAnswers, ThatToTheSameStopBeforeAnotherWriteIsNone) {
  open_with_stop_answered_once();
  submit(job_of(1, "05 0001 FF00"));
  advance(60ms);
  ASSERT_THAT(frames_, SizeIs(3));
  time_out();
  submit(job(kStop));
  ASSERT_THAT(frames_, SizeIs(4));
  advance(10ms);
  line(kStopFrame);  // of the first stop
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer));
  advance(10ms);
  line(kStopFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer, Ending::answered));
}

// A broadcast is a write between, too.
TEST_F(BusStopAnswers, ThatToTheSameStopBeforeABroadcastIsNone) {
  open_with_stop_answered_once();
  submit(job_of(1, kMove, modbus::kBroadcastAddress));
  advance(40ms);
  ASSERT_THAT(frames_, SizeIs(3));
  submit(job(kStop));
  ASSERT_THAT(frames_, SizeIs(4));
  advance(10ms);
  line(kStopFrame);  // of the first stop
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::transmitted));
  advance(10ms);
  line(kStopFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::transmitted, Ending::answered));
}

// Whoever asks an offline device waits for a shorter time; its quarantine is none the shorter for
// that.
TEST_F(BusStopAnswers, TheLateAnswerToAMoveOfADeviceThatIsOfflineIsNone) {
  auto slow = settings();
  slow.timing.response_timeout = 300ms;
  slow.timing.offline_after = 1;
  slow.line.echo = false;
  open(slow, {axis(slow)});
  submit(job_of(1, kMoveBy16));
  advance(310ms);
  ASSERT_TRUE(bus_->devices()[1].health.is_offline());
  advance(200ms);  // longer than a probe is waited for, and its quarantine would be
  submit(job(kStopBy16));
  ASSERT_THAT(frames_, SizeIs(2));
  expect_that_only_the_second_answer_is_the_stops();
}

// The quarantine is over but for what an adapter may still keep.
TEST_F(BusStopAnswers, TheLateAnswerToAMoveThatAnAdapterKeptInTheLongestQuarantineIsNone) {
  auto longest = settings();
  longest.timing.quarantine_max = 100ms;  // as long as the quarantine is
  longest.line.echo = false;
  open(longest, {axis(longest)});
  submit(job_of(1, kMoveBy16));
  advance(kUnanswered + 101ms);
  submit(job(kStopBy16));
  ASSERT_THAT(frames_, SizeIs(2));
  advance(10ms);
  line(kAnswerBy16);  // of the move
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  advance(10ms);
  line(kAnswerBy16);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
}

// Of an unknown function only silence ends it.
TEST_F(BusStopAnswers, NoiseBehindTheAnswerToAnotherRequestDoesNotKeepItForLong) {
  open_axis();
  submit(job_of(1, "41 01"));
  advance(10ms);
  line("01 41 12");
  submit(job(kStop));
  for (int times = 0; times < 15; ++times) {
    advance(15ms);
    line("FF");
  }
  EXPECT_THAT(frames_, SizeIs(2));
}

}  // namespace
}  // namespace mbgate::test
