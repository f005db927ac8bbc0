// SPDX-License-Identifier: Apache-2.0
// Lines that may hear themselves, and what comes before a request has left.
#include "echo_rig.hpp"
#include "unit/bus/queue/stop_axis.hpp"

namespace mbgate::test {
namespace {

using Fault = bus::LineFault;

TEST_F(BusEcho, AReadProvesIt) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(1ms);
  line("01 03 00 00");
  advance(1ms);
  line("00 01 84 0A");
  EXPECT_THAT(faults_, IsEmpty());  // the device may have said so
  advance(10ms);
  line(kAnswer);
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found));
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(10ms);
  submit(job(kWritePdu));
  advance(1ms);
  line(kRepetition);
  EXPECT_THAT(endings_, SizeIs(1));  // its echo
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

TEST_F(BusEcho, ABroadcastDoesNotProveIt) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kWritePdu, 0));
  advance(15ms);  // it has left, and its echo comes late
  line("00 06 00 00 00 01 49 DB");
  EXPECT_THAT(faults_, IsEmpty());
  EXPECT_EQ(bus_->counters().foreign_frames, 0U);
}

TEST_F(BusEcho, AReadWithoutItShowsThatThereIsNone) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  advance(10ms);
  submit(job(kWritePdu));
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  EXPECT_THAT(faults_, IsEmpty());
}

// It was damaged, or something else came; and then, at once or later, the answer.
TEST_F(BusEcho, AReadShowsThatThereIsNoneOnlyIfNothingComesBeforeItsAnswer) {
  const std::string answer = kAnswer;
  for (const std::string& before :
       {std::string("01 03 00 00 00 01 84 0B"), std::string("00"),
        std::string("02 06 00 00 00 01 48 39"), std::string("01 03 00 00")}) {
    for (const Duration pause : {0ms, 4ms}) {
      endings_.clear();
      faults_.clear();
      open_as(bus::LineKind::virtual_line);
      submit(job(kRead));
      advance(10ms);
      line(before + (pause == 0ms ? answer : ""));
      advance(pause);
      if (pause > 0ms) {
        line(answer);
      }
      advance(400ms);
      submit(job(kWritePdu));
      advance(10ms);
      line(kRepetition);
      EXPECT_THAT(faults_, ElementsAre(Fault::echo_unproven)) << before;
    }
  }
}

TEST_F(BusEcho, OfAnEarlierWriteMayComeUntilTenSecondsAfterItsTimeout) {
  open_as(bus::LineKind::virtual_line, true);
  submit(job(kWritePdu));
  advance(kEmission + 100ms + 9950ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  submit(job(kWritePdu));
  advance(10ms);
  line(kRepetition);
  line(kRepetition);
  EXPECT_THAT(endings_, SizeIs(1));
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
}

TEST_F(BusEcho, WhatBeginsLikeItButEndsOtherwiseIsAnAnswer) {
  open_as(bus::LineKind::virtual_line);
  submit(job("01 0100 0008"));
  advance(10ms);
  line("01 01 01");
  advance(1ms);
  line("55 91 B7");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusEcho, AnAnswerThatIsHeldForItIsNotTimedOut) {
  open_as(bus::LineKind::virtual_line);
  submit(job("01 0100 0008"));
  advance(kEmission + 99ms);
  line("01 01 01");
  advance(3ms);
  line("55 91 B7");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusEcho, ALateAnswerThatBeginsLikeItMayPauseForTheSlack) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(kEmission + 101ms);
  for (const auto* part : {"01", "03", "02 12", "34 B5 33"}) {
    EXPECT_EQ(bus_->counters().late_responses, 0U);
    advance(16ms);
    line(part);
  }
  EXPECT_EQ(bus_->counters().late_responses, 1U);
}

TEST_F(BusEcho, ALateAnswerThatBeginsLikeItMayEndBesideTheNextRequest) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(kEmission + 101ms);
  line("01 03");
  submit(job(kRead, 2));
  advance(20ms);
  ASSERT_THAT(frames_, ElementsAre(kReadFrame, kOtherDevice));
  line("02 12 34 B5 33");
  EXPECT_EQ(bus_->counters().late_responses, 1U);
}

TEST_F(BusEcho, ALoneRepetitionIsTakenUntilAReadHasShownItAndSaidOnce) {
  open_as(bus::LineKind::virtual_line);
  hear_device();
  for (int times = 0; times < 2; ++times) {
    submit(job(kWritePdu));
    advance(10ms);
    line(kRepetition);
    advance(10ms);
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_unproven));
}

TEST_F(BusEcho, ARepetitionThatComesLaterThanAnAdapterKeepsOneIsNoEcho) {
  open_as(bus::LineKind::virtual_line);
  hear_device();
  submit(job(kWritePdu));
  advance(kEmission + 21ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_THAT(faults_, IsEmpty());
}

TEST_F(BusEcho, WhatStandsBehindARepetitionIsTheAnswer) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kWritePdu));
  advance(10ms);
  line(std::string(kRepetition) + kRefusal);
  EXPECT_THAT(faults_, IsEmpty());
  ASSERT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(jobs_[0].transactions[0].response, modbus::Pdu::from(unhex("86 02")));
}

// Of two drives at one address, or of a repeater: from now on a single one is still an answer.
TEST_F(BusEcho, TwoAnswersThatLookLikeItProveNothing) {
  open_as(bus::LineKind::virtual_line);
  hear_device();
  for (const auto& answers : {std::string(kRepetition) + kRepetition, std::string(kRepetition)}) {
    submit(job(kWritePdu));
    advance(10ms);
    line(answers);
    advance(1s);
  }
  EXPECT_THAT(faults_, testing::Not(testing::Contains(Fault::echo_found)));
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

TEST_F(BusEcho, OnAPacedLineNothingThatBeginsBeforeTheRequestHasLeftIsAnAnswer) {
  open_as(bus::LineKind::uart, false);
  submit(job(kWritePdu));
  advance(2ms);
  line(kRepetition);  // the echo that the settings deny
  EXPECT_THAT(endings_, IsEmpty());
  time_out();
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(BusEcho, OnAPacedLineARepetitionBeforeThatProvesItWithAnAnswerBehindIt) {
  open_as(bus::LineKind::uart);
  submit(job(kWritePdu));
  advance(2ms);
  line(kRepetition);
  EXPECT_THAT(endings_, IsEmpty());
  EXPECT_THAT(faults_, IsEmpty());
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found));
}

TEST_F(BusEcho, OnAPacedLineWithoutOneARepetitionBeforeThatIsUnasked) {
  open_as(bus::LineKind::uart);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  advance(10ms);
  submit(job(kWritePdu));
  advance(2ms);
  line(kRepetition);
  EXPECT_EQ(bus_->counters().unsolicited_frames, 1U);
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

TEST_F(BusEcho, AFittingReadAnswerBeforeThatIsSaidOnce) {
  open_as(bus::LineKind::uart, false);
  for (int times = 0; times < 2; ++times) {
    submit(job(kRead));
    advance(2ms);
    line(kAnswer);
    advance(kEmission + 400ms);
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
  EXPECT_THAT(faults_, ElementsAre(Fault::answered_while_sending));
}

// Read as an answer it would bring the three bytes A8 00 17.
TEST_F(BusEcho, ThatComesBehindAnAnswerPaysForNoneThatIsOwed) {
  open_retrying();
  submit(job("01 03A8 0017"));
  time_out();
  ASSERT_THAT(frames_, SizeIs(2));
  advance(10ms);
  line("01 01 03 8C E3 4E 34 A1");
  line("01 01 03 A8 00 17 FD A0");
  submit(job("01 03BF 0017"));
  advance(20ms);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusEcho, BehindThatOfAStopAnExceptionMayBeThatOfTheWriteBefore) {
  open_as(bus::LineKind::virtual_line, {}, {axis(settings())});
  for (const auto& heard : {std::string(kReadFrame) + kAnswer, std::string(kAnswer)}) {
    submit(job(kRead));
    advance(10ms);
    line(heard);  // the second one without its echo: whether there is one is unknown again
    time_out();
    advance(400ms);
  }
  submit(job(kMove));
  advance(10ms);
  line(kMoveFrame);
  time_out();
  submit(job(kStop));
  advance(10ms);
  endings_.clear();
  line(std::string(kStopFrame) + kRefusal);  // of the move
  EXPECT_THAT(endings_, IsEmpty());
  line(kStopFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusEcho, IsStillThereIfManyAnswersLackItButNotInARow) {
  open_and_learn(bus::LineKind::virtual_line);
  for (int times = 0; times < 30; ++times) {
    advance(400ms);
    submit(job(kRead));
    advance(10ms);
    line(times % 3 < 2 ? kAnswer : std::string(kReadFrame) + kAnswer);
    time_out();
  }
  EXPECT_THAT(faults_, testing::Not(testing::Contains(bus::LineFault::echo_gone)));
}

}  // namespace
}  // namespace mbgate::test
