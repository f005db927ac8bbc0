// SPDX-License-Identifier: Apache-2.0
// Echoes that were damaged, lost or late, and what the line is taken for then.
#include "echo_rig.hpp"
#include "unit/bus/queue/stop_axis.hpp"

namespace mbgate::test {
namespace {

using Fault = bus::LineFault;

// The reader was late: an echo has no other end than the wait for the answer.
TEST_F(BusEcho, OnceShownALateRepetitionIsNoAnswerEither) {
  open_and_learn(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);  // without an echo
  time_out();
  ASSERT_THAT(faults_, ElementsAre(Fault::echo_found, Fault::echo_differed));
  advance(11s);
  submit(job(kWritePdu));
  advance(kEmission + 21ms);
  line(kRepetition);
  time_out();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer, Ending::no_answer));
}

TEST_F(BusEcho, OnceShownAReadThatLacksItDoesNotSayThatThereIsNone) {
  open_and_learn(bus::LineKind::virtual_line);
  for (int times = 0; times < 2; ++times) {
    advance(11s);
    submit(job(kRead));
    advance(10ms);
    line(kAnswer);  // without an echo
    time_out();
  }
  ASSERT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer, Ending::answered));
  advance(11s);
  submit(job(kWritePdu));
  advance(10ms);
  line(kRepetition);
  time_out();
  EXPECT_THAT(endings_, SizeIs(4));
  EXPECT_EQ(endings_.back(), Ending::no_answer);
}

// Something stands before it, so that it is not taken out as an echo.
TEST_F(BusEcho, WithZerosBehindItIsNoAnswerToARequestWithoutFields) {
  open_as(bus::LineKind::virtual_line);
  submit(job("07"));
  advance(10ms);
  line("02 03 02 12 34 F1 33");
  advance(5ms);
  line("01 07 41 E2 00");
  time_out();
  advance(11s);
  submit(job("0B"));
  advance(10ms);
  line("02 03 02 12 34 F1 33");
  advance(5ms);
  line("01 0B 41 E7 00 00 00 00");
  time_out();
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
}

TEST_F(BusEcho, BehindItAnAnswerMayBeginAsItDoes) {
  open_and_learn(bus::LineKind::virtual_line);
  submit(job("07"));
  advance(10ms);
  line("01 07 41 E2");
  line("01 07 41 E2 00");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

// What was taken for an echo was none, or the adapter was set otherwise.
TEST_F(BusEcho, IsNotThereAnyMoreAfterManyAnswersThatLackIt) {
  open_and_learn(bus::LineKind::virtual_line);
  for (int times = 0; times < 9; ++times) {
    advance(11s);
    submit(job(kRead));
    advance(10ms);
    line(kAnswer);  // without an echo
    time_out();
  }
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found, Fault::echo_differed, Fault::echo_gone));
  advance(11s);
  submit(job(kWritePdu));
  advance(10ms);
  line(kRepetition);
  EXPECT_EQ(endings_.back(), Ending::answered);
}

TEST_F(BusEcho, IsToldOnceWhereTheSettingsDenyIt) {
  open_as(bus::LineKind::uart, false);
  for (int times = 0; times < 3; ++times) {
    line("02 03 02 12 34 F1 33");  // of whoever it is
    advance(10ms);
    submit(job(kRead));
    advance(1ms);
    line(kReadFrame);
    advance(10ms);
    line(kAnswer);
    advance(10ms);
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered, Ending::answered));
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_denied));
}

// It asked a moment before, and the adapter kept that.
TEST_F(BusEcho, IsNotToldWhereAnotherClientMayHaveAskedForTheSame) {
  open_as(bus::LineKind::uart, false);
  for (int times = 0; times < 4; ++times) {
    submit(job(kRead));
    advance(10ms);
    line(std::string(times % 2 == 0 ? kReadFrame : "") + kAnswer);
    advance(10ms);
    time_out();
  }
  EXPECT_THAT(faults_, IsEmpty());
}

// A UART may hand over all of it at once, and a drive need not wait for t3.5.
TEST_F(BusEcho, ThatTheSettingsDenyDoesNotHideTheAnswerBehindIt) {
  open_as(bus::LineKind::uart, false);
  submit(job(kRead));
  advance(kEmission);
  line(kReadFrame);
  advance(4ms);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusEcho, ThatTheSettingsDenyDoesNotHideTheAnswerBehindItThoughItBeginsLikeOne) {
  open_as(bus::LineKind::uart, false);
  submit(job("03 0400 0002"));
  advance(kEmission);
  line("01 03 04 00 00 02 C5 3B");
  advance(10ms);
  line("01 03 04 00 07 00 08 4A 34");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusEcho, ThatCannotBeOneIsAnotherClientsRequest) {
  open_as(bus::LineKind::uart, false);
  submit(job(kRead));
  advance(2 * kEmission);
  line(kReadFrame);
  advance(1ms);
  line(kAnswer);
  EXPECT_THAT(endings_, IsEmpty());
}

TEST_F(BusEcho, WhereItIsNotCertainAnyMoreTheSecondRepetitionIsTheAnswer) {
  open_and_learn(bus::LineKind::virtual_line);
  advance(11s);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);  // without an echo
  time_out();
  advance(11s);
  submit(job(kWritePdu));
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, SizeIs(2));
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer, Ending::answered));
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found, Fault::echo_differed));
}

TEST_F(BusEcho, IsLearnedAnewWhenItIsNotThereAnyMore) {
  open_and_learn(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);  // without an echo
  time_out();
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found, Fault::echo_differed));
  advance(11s);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer, Ending::answered));
}

// The spoilt echo was all that came; it is not to be made up from what was sent.
TEST_F(BusEcho, ThatDifferedIsNotHeardAgainWhenTheTimeIsOver) {
  open_and_learn(bus::LineKind::uart);
  submit(job(kWritePdu));
  advance(10ms);
  line(kRefusal);  // without an echo
  time_out();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer));
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found, Fault::echo_differed));
  EXPECT_EQ(bus_->counters().unsolicited_frames, 0U);
}

/// A device that is stopped by kWritePdu, which is repeated if it is not answered.
class BusLateEcho : public Bus {
 protected:
  void open_with_stop() {
    drive::Device axis;
    axis.profile.stops = {{.address = 0, .value = 1}};
    axis.timing = settings().timing;
    auto hearing = settings();
    hearing.line.echo = true;
    open(hearing, {axis});
  }
  /// A stop whose echo did not come in time; its repetition has left.
  void repeat_stop() {
    submit(job(kWritePdu));
    advance(kEmission + 103ms + kEmission);
    ASSERT_THAT(frames_, SizeIs(2));
  }
};

TEST_F(BusLateEcho, IsNotTheAnswerToTheSameRequest) {
  open_with_stop();
  repeat_stop();
  line(kRepetition);  // late
  advance(2ms);
  line(kRepetition);  // in time
  EXPECT_THAT(endings_, IsEmpty());
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(bus_->counters().echo_mismatches, 0U);
}

TEST_F(BusLateEcho, MayComeInTheSamePieceAsTheOther) {
  open_with_stop();
  repeat_stop();
  line(std::string(kRepetition) + kRepetition);
  EXPECT_THAT(endings_, IsEmpty());
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

// Nobody can tell its answer from the echo that was lost.
TEST_F(BusLateEcho, ThatWasLostCostsOneAnswer) {
  open_with_stop();
  repeat_stop();
  line(std::string(kRepetition) + kRepetition);  // the echo and the answer
  time_out();
  EXPECT_THAT(endings_, IsEmpty());
  ASSERT_THAT(frames_, SizeIs(3));
  advance(kEmission);
  line(std::string(kRepetition) + kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusLateEcho, ThatComesBetweenIsNotOwedAnyMore) {
  open_with_stop();
  submit(job(kWritePdu));
  advance(kEmission + 101ms);  // the silence before the repetition runs
  line(kRepetition);
  advance(2 * kEmission);
  ASSERT_THAT(frames_, SizeIs(2));
  line(std::string(kRepetition) + kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusEcho, IsNotClaimedWhileAnIdenticalAnswerIsOwed) {
  drive::Device axis;
  axis.profile.stops = {{.address = 0, .value = 1}};
  axis.timing = settings().timing;
  auto learning = settings();
  learning.line.echo.reset();
  learning.line.paced = true;
  open(learning, {axis});
  submit(job(kWritePdu));
  advance(kEmission + 103ms);  // unanswered: repeated
  ASSERT_THAT(frames_, SizeIs(2));
  line(kRepetition);  // late
  EXPECT_THAT(faults_, IsEmpty());
  EXPECT_THAT(endings_, IsEmpty());
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

// Nobody has said so, and the drive is dead: its stop comes back, and is repeated.
TEST_F(BusEcho, OfAStopOnAPacedLineIsNoLateAnswerToTheOneBefore) {
  auto denying = settings();
  denying.timing.offline_after = 2;
  bus_.emplace(denying, std::vector<drive::Device>{axis(denying)});
  bus_->start();
  bus_->handle_opened(now_, bus::LineKind::uart);
  drain();
  advance(5ms);
  submit(job(kStop));
  for (int tries = 0; tries < 4; ++tries) {
    advance(1ms);
    line(kStopFrame);
    advance(kEmission + 100ms - 1ms);
  }
  EXPECT_TRUE(bus_->devices()[1].health.is_offline());
  EXPECT_EQ(bus_->counters().late_responses, 0U);
}

}  // namespace
}  // namespace mbgate::test
