// SPDX-License-Identifier: Apache-2.0
// When a line is busy with what it brings, and for how long at most.
#include "unit/bus/bus_rig.hpp"
#include "unit/bus/queue/stop_axis.hpp"

namespace mbgate::test::bus_busy_line_test {
namespace {

class BusBusyLine : public Bus {
 protected:
  void expect_next_after(Duration pause) {
    advance(pause - 1ms);
    EXPECT_THAT(frames_, SizeIs(1));
    advance(1ms);
    EXPECT_THAT(frames_, SizeIs(2));
  }
};

// Each silence shows that the byte before was none, and the next one may be the first.
TEST_F(BusBusyLine, AnAnswerThatBeginsAnewAndAnewIsNone) {
  open(settings(), {axis(settings(), 2)});
  submit(job(kRead));
  advance(95ms);
  const Instant since = now_;
  while (endings_.empty() && now_ < since + 5s) {
    line("01");
    advance(15ms);
  }
  EXPECT_LT(now_, since + 1300ms) << "one second, and the longest frame";
}

TEST_F(BusBusyLine, NorDoesItKeepAStopWaiting) {
  open(settings(), {axis(settings(), 2)});
  submit(job(kRead));
  advance(95ms);
  line("01");
  submit(job_of(1, kStop, 2));
  const Instant since = now_;
  while (frames_.size() < 2 && now_ < since + 5s) {
    advance(15ms);
    line("01");
  }
  EXPECT_LT(now_, since + 2100ms) << "stop_deadline, as the line is never silent";
}

TEST_F(BusBusyLine, NorInAscii) {
  auto ascii = settings();
  ascii.line.framing = bus::Framing::ascii;
  open(ascii, {axis(ascii, 2)});
  submit(job("03 0000 007D"));
  advance(90ms);
  line("3A 30 31");
  submit(job_of(1, kStop, 2));
  const Instant since = now_;
  while (frames_.size() < 2 && now_ < since + 5s) {
    advance(50ms);
    line("3A 30 31");
  }
  EXPECT_LT(now_, since + 500ms);
}

// It may be a second answer.
TEST_F(BusBusyLine, NothingIsSentIntoAFrameThatBeginsBehindAnAnswer) {
  open(settings());
  submit(job(kRead));
  submit(job(kRead, 2));
  advance(20ms);
  line(std::string(kAnswer) + "01 03 02");
  expect_next_after(20ms);
}

TEST_F(BusBusyLine, NorIntoALateAnswerThatBeginsAsTheEchoWould) {
  auto learning = settings();
  learning.line.echo.reset();
  open(learning);
  submit(job(kRead));
  time_out();
  advance(10ms);
  line("01 03");
  submit(job(kRead, 2));
  expect_next_after(20ms);
}

TEST_F(BusBusyLine, NorAfterAReload) {
  open(settings());
  submit(job(kRead));
  time_out();
  advance(10ms);
  line("01 03 02");
  submit(job(kRead, 2));
  advance(1ms);
  update(settings(), usual_devices(settings()));
  expect_next_after(19ms);
}

TEST_F(BusBusyLine, SeveralStopsWaitForSilenceOnlyOnce) {
  auto hasty = settings();
  hasty.timing.stop_retries = 0;
  open(hasty, {axis(hasty), axis(hasty, 2)});
  line("55");
  for (const std::uint8_t address : std::array<std::uint8_t, 2>{1, 2}) {
    submit(job(kStop, address));
  }
  const Instant since = now_;
  while (now_ < since + 2300ms) {
    advance(1ms);
    line("55");
  }
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusBusyLine, OnASlowLineTheLongestFrameIsNoNoise) {
  auto slow = settings();
  slow.line.baud = modbus::Baud{1200};
  open(slow, {axis(slow)});
  // 2816 bits, and a tenth more.
  EXPECT_EQ(bus::longest_stream(slow), 2581333333ns);
  EXPECT_EQ(bus::stop_deadline(slow), slow.stop_wait + 2581333333ns);
  advance(1s);
  for (int bytes = 0; bytes < 256; ++bytes) {
    advance(9ms);
    line("55");
  }
  EXPECT_EQ(never_silent_, 0U);
}

}  // namespace
}  // namespace mbgate::test::bus_busy_line_test
