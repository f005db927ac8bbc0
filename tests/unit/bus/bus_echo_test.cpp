// SPDX-License-Identifier: Apache-2.0
// Lines that may hear themselves, and what comes before a request has left.
#include "bus_rig.hpp"

namespace mbgate::test {
namespace {

using Fault = bus::LineFault;

constexpr auto kWritePdu = "06 0000 0001";
constexpr auto kRepetition = "01 06 00 00 00 01 48 0A";  // the frame, its echo, and its answer
constexpr auto kReadEcho = "01 03 00 00 00 01 84 0A";
constexpr auto kRefusal = "01 86 02 C3 A1";

class BusEcho : public Bus {
 protected:
  void open_as(bus::LineKind kind, std::optional<bool> echo = {}) {
    auto learning = settings();
    learning.line.echo = echo;
    bus_.emplace(learning, std::vector<drive::Device>{});
    bus_->start();
    bus_->handle_opened(now_, kind);
    drain();
    advance(5ms);
  }
};

TEST_F(BusEcho, AReadProvesIt) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(1ms);
  line("01 03 00 00");
  advance(1ms);
  line("00 01 84 0A");
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found));
  advance(10ms);
  line(kAnswer);
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

TEST_F(BusEcho, ABroadcastProvesIt) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kWritePdu, 0));
  advance(15ms);  // it has left, and its echo comes late
  line("00 06 00 00 00 01 49 DB");
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found));
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

TEST_F(BusEcho, ALoneRepetitionIsTakenUntilAReadHasShownItAndSaidOnce) {
  open_as(bus::LineKind::virtual_line);
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
  submit(job(kWritePdu));
  advance(kEmission + 21ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_THAT(faults_, IsEmpty());
}

// The reader was late: an echo has no other end than the wait for the answer.
TEST_F(BusEcho, OnceShownALateRepetitionIsNoAnswerEither) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(10ms);
  line(std::string(kReadEcho) + kAnswer);
  advance(10ms);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);  // without an echo
  time_out();
  ASSERT_THAT(faults_, ElementsAre(Fault::echo_found, Fault::echo_differed));
  advance(400ms);
  submit(job(kWritePdu));
  advance(kEmission + 21ms);
  line(kRepetition);
  time_out();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer, Ending::no_answer));
}

TEST_F(BusEcho, OnceShownAReadThatLacksItDoesNotSayThatThereIsNone) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(10ms);
  line(std::string(kReadEcho) + kAnswer);
  for (int times = 0; times < 2; ++times) {
    advance(400ms);
    submit(job(kRead));
    advance(10ms);
    line(kAnswer);  // without an echo
    time_out();
  }
  ASSERT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer, Ending::answered));
  advance(400ms);
  submit(job(kWritePdu));
  advance(10ms);
  line(kRepetition);
  time_out();
  EXPECT_THAT(endings_, SizeIs(4));
  EXPECT_EQ(endings_.back(), Ending::no_answer);
}

TEST_F(BusEcho, AReadWhoseEchoWasDamagedShowsNothing) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(10ms);
  line("01 03 00 00 00 11 84 0A");
  advance(10ms);
  line(kAnswer);
  advance(10ms);
  submit(job(kWritePdu));
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_unproven));
}

TEST_F(BusEcho, WhereItIsNotCertainAnyMoreTheSecondRepetitionIsTheAnswer) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(10ms);
  line(std::string(kReadEcho) + kAnswer);
  advance(400ms);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);  // without an echo
  time_out();
  advance(400ms);
  submit(job(kWritePdu));
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, SizeIs(2));
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer, Ending::answered));
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found, Fault::echo_differed, Fault::echo_found));
}

TEST_F(BusEcho, OneThatDifferedIsNotHeardAtTheDeadline) {
  open_as(bus::LineKind::uart);
  submit(job(kRead));
  advance(10ms);
  line(std::string(kReadEcho) + kAnswer);
  advance(400ms);
  submit(job(kWritePdu));
  advance(2ms);
  line("C0 28 E7 2A");
  time_out();
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found, Fault::echo_differed));
}

TEST_F(BusEcho, WhatStandsBehindARepetitionIsTheAnswer) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kWritePdu));
  advance(10ms);
  line(std::string(kRepetition) + kRefusal);
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found));
  ASSERT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(jobs_[0].transactions[0].response, modbus::Pdu::from(unhex("86 02")));
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

TEST_F(BusEcho, OnAPacedLineARepetitionBeforeThatProvesIt) {
  open_as(bus::LineKind::uart);
  submit(job(kWritePdu));
  advance(2ms);
  line(kRepetition);
  EXPECT_THAT(endings_, IsEmpty());
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found));
  advance(10ms);
  line(kRepetition);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
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

TEST_F(BusEcho, IsLearnedAnewWhenItIsNotThereAnyMore) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(10ms);
  line(std::string(kReadEcho) + kAnswer);
  advance(10ms);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);  // without an echo
  time_out();
  EXPECT_THAT(faults_, ElementsAre(Fault::echo_found, Fault::echo_differed));
  advance(400ms);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer, Ending::answered));
}

TEST_F(BusEcho, IsNotClaimedWhileAnIdenticalAnswerIsOwed) {
  drive::Device axis;
  axis.profile.stops = {{.address = 0, .value = 1}};
  axis.timing = settings().timing;
  auto learning = settings();
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

}  // namespace
}  // namespace mbgate::test
