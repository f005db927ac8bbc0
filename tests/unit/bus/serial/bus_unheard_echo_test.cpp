// SPDX-License-Identifier: Apache-2.0
// Frames that are identical to their requests, and prove nothing.
#include "echo_rig.hpp"
#include "unit/bus/queue/stop_axis.hpp"

namespace mbgate::test {
namespace {

// It may be switched off, or not be there at all.
TEST_F(BusEcho, ALoneRepetitionAcknowledgesNothingOfADeviceThatWasNotHeard) {
  for (const Duration after : {10ms, 60ms}) {
    faults_.clear();
    endings_.clear();
    open_as(bus::LineKind::virtual_line);
    hear_device();
    for (int times = 0; times < 2; ++times) {
      submit(job(kWritePdu, 2));
      advance(after);
      line("02 06 00 00 00 01 48 39");
      EXPECT_THAT(endings_, SizeIs(times));
      time_out();
      advance(1s);
    }
    EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
    EXPECT_THAT(faults_, ElementsAre(bus::LineFault::echo_unproven));
  }
}

TEST_F(BusEcho, NorAStopWhichIsRepeatedAndTold) {
  open_as(bus::LineKind::virtual_line, {}, {axis(settings())});
  submit(job(kStop));
  for (std::size_t tries = 1; tries <= 4; ++tries) {
    ASSERT_THAT(frames_, SizeIs(tries));
    advance(10ms);
    line(kStopFrame);
    time_out();
  }
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_THAT(notices_, testing::Contains(bus::DeviceNotice::Kind::stop_unanswered));
}

// It came while the repetition was sent, and may be the echo of either.
TEST_F(BusEcho, WhatMayBeOneIsNoSilenceOfItsDevice) {
  auto learning = settings();
  learning.line.echo.reset();
  learning.line.paced = true;
  open(learning, {axis(learning)});
  submit(job(kStop));
  advance(kEmission + 103ms);
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(bus_->devices()[1].health.unanswered_in_row(), 1U);
  line(kStopFrame);
  time_out();
  EXPECT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(bus_->devices()[1].health.unanswered_in_row(), 1U);
}

// The adapter kept the echo of the try before. Behind its own, it looks like the answer.
TEST_F(BusEcho, TheEchoOfAStopSentBeforeTheLineWasReopenedAcknowledgesNothing) {
  open_as(bus::LineKind::virtual_line, true, {axis(settings())});
  submit(job(kStop));
  advance(2ms);
  bus_->handle_lost(now_, bus::Loss::failed);
  drain();
  bus_->handle_opened(now_, bus::LineKind::virtual_line);
  drain();
  advance(10ms);
  ASSERT_THAT(frames_, SizeIs(2)) << "it is sent again";
  line(std::string(kStopFrame) + kStopFrame);
  EXPECT_THAT(endings_, IsEmpty());
  line(kStopFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

// What came may be the drive's answer or an echo, which a read tells.
TEST_F(BusEcho, AReadGoesBeforeTheRepetitionOfAStopThatMayHaveBeenAnswered) {
  open_as(bus::LineKind::virtual_line, {}, {axis(settings())});
  submit(job(kStop));
  submit(job_of(1, kRead));
  submit(job_of(2, kMove));
  advance(10ms);
  line(kStopFrame);
  time_out();
  EXPECT_THAT(frames_, ElementsAre(kStopFrame, kReadFrame));
}

TEST_F(BusEcho, AReadWithoutOneShowsThatTheRepetitionBeforeWasTheAnswer) {
  open_as(bus::LineKind::virtual_line);
  const auto write = [this] {
    submit(job(kWritePdu));
    advance(10ms);
    line("01 06 00 00 00 01 48 0A");
    time_out();
    advance(1s);
  };
  write();
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  write();
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered, Ending::answered));
}

TEST_F(BusEcho, AnAnswerToTheFirstTryBeforeTheEchoOfTheSecondShowsNothing) {
  drive::Device patient{"axis", {}, 1, settings().timing};
  patient.timing.retries = 1;
  open_as(bus::LineKind::virtual_line, {}, {patient});
  submit(job(kRead));
  time_out();
  line(kAnswer);
  line(kReadFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(1s);
  submit(job(kWritePdu, 2));
  advance(10ms);
  line("02 06 00 00 00 01 48 39");
  time_out();
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer));
}

// A drive does that with one write.
TEST_F(BusEcho, AWholeRequestAsItsAnswerProvesNothing) {
  open_as(bus::LineKind::virtual_line);
  submit(job(kRead));
  advance(10ms);
  line(kAnswer);
  advance(10ms);
  const auto write_all = [&](std::string_view answer) {
    submit(job("10 0000 0001 02 0001"));
    advance(20ms);
    line(answer);
    time_out();
    advance(400ms);
  };
  write_all("01 10 00 00 00 01 02 00 01 67 90");
  EXPECT_THAT(faults_, IsEmpty());
  advance(10s);  // it owes no answer any more
  for (int times = 0; times < 3; ++times) {
    write_all("01 10 00 00 00 01 01 C9");
    submit(job(kRead));
    advance(10ms);
    line(kAnswer);
    advance(10ms);
  }
  EXPECT_THAT(endings_,
              ElementsAre(Ending::answered, Ending::no_answer, Ending::answered, Ending::answered,
                          Ending::answered, Ending::answered, Ending::answered, Ending::answered));
  EXPECT_THAT(faults_, IsEmpty());
}

}  // namespace
}  // namespace mbgate::test
