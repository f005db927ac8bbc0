// SPDX-License-Identifier: Apache-2.0
// What a bus says of its line and devices, and on what it rests.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

using Notice = bus::DeviceNotice::Kind;
using bus::Quality;

constexpr auto kDamagedAnswer = "01 03 02 12 35 B5 33";

class BusQuality : public Bus {
 protected:
  void ask() {
    submit(job(kRead));
    advance(kEmission + kT35 + 20ms);
  }
  /// Until nothing is owed any more.
  void rest() { advance(300ms); }
};

TEST_F(BusQuality, BadCrcsAreJudgedThoughNoAnswerWasEverGood) {
  open(settings());
  for (int at = 0; at < 5; ++at) {
    ask();
    line(kDamagedAnswer);
    rest();
  }
  EXPECT_EQ(bus_->diagnosis().quality()[1].verdict().quality, Quality::bad_crc);
  EXPECT_EQ(bus_->diagnosis().quality()[1].verdict().percent(), 100U);
  ASSERT_THAT(qualities_, SizeIs(1));
  EXPECT_EQ(qualities_[0].address, 1);
  EXPECT_EQ(qualities_[0].verdict.of, 5U);
}

TEST_F(BusQuality, OfALineThatWasOpenedAgainIsJudgedAnew) {
  open(settings());
  for (int at = 0; at < 5; ++at) {
    ask();
    line(kDamagedAnswer);
    rest();
  }
  bus_->handle_lost(now_);
  bus_->handle_opened(now_);
  drain();
  EXPECT_EQ(bus_->diagnosis().quality()[1].verdict().quality, Quality::unknown);
}

TEST_F(BusQuality, BytesThatNeverMakeAFrameAreTold) {
  open(settings());
  for (int at = 0; at < 5; ++at) {
    ask();
    line("E6 18 86");
    rest();
  }
  EXPECT_EQ(bus_->diagnosis().quality()[1].verdict().quality, Quality::no_frame);
  EXPECT_THAT(qualities_, SizeIs(1));
}

TEST_F(BusQuality, WhereBytesComeUnaskedTooTheyMayBeNoise) {
  open(settings());
  for (int at = 0; at < 12; ++at) {
    ask();
    line("E6 18 86 9E 06");
    rest();
    line("E6 18");
    rest();
  }
  EXPECT_EQ(bus_->diagnosis().quality()[1].verdict().quality, Quality::unknown);
}

// A driver that turns off behind each request, and nobody there.
TEST_F(BusQuality, AGlitchBehindEachRequestIsNobodysAnswer) {
  open(settings());
  for (int at = 0; at < 20; ++at) {
    ask();
    line("00 FF");
    rest();
  }
  EXPECT_EQ(bus_->diagnosis().quality()[1].verdict().quality, Quality::unknown);
}

TEST_F(BusQuality, ASlowDriveIsTold) {
  open(settings());
  for (int at = 0; at < 4; ++at) {
    ask();
    advance(160ms);
    line(kAnswer);
    rest();
  }
  EXPECT_EQ(bus_->diagnosis().quality()[1].verdict().quality, Quality::late);
  ASSERT_THAT(qualities_, SizeIs(1));
  EXPECT_GE(qualities_[0].verdict.needed, 180ms);
  EXPECT_LE(qualities_[0].verdict.needed, 220ms);
}

TEST_F(BusQuality, ADriveThatNeverAnsweredIsNotCalledLost) {
  auto watched = settings();
  watched.timing.offline_after = 1;
  open(watched);
  ask();
  rest();
  ASSERT_THAT(notices_, ElementsAre(Notice::lost));
  EXPECT_FALSE(last_notice_.answered_before);
  EXPECT_EQ(last_notice_.transmissions, 1U);
}

TEST_F(BusQuality, ForeignIsNobodyWithinQuarantineMaxOfTheOpening) {
  open(settings());
  advance(9s);
  line("02 03 02 12 34 F1 33");
  advance(50ms);
  EXPECT_THAT(notices_, IsEmpty());
  advance(1s);
  line("02 03 02 12 34 F1 33");
  EXPECT_THAT(notices_, ElementsAre(Notice::foreign));
}

TEST_F(BusQuality, ForeignIsToldOnceForEachOpeningOfTheLine) {
  open(settings());
  for (std::size_t openings = 1; openings <= 2; ++openings) {
    for (int frames = 0; frames < 2; ++frames) {
      advance(11s);
      line("02 03 02 12 34 F1 33");
    }
    EXPECT_THAT(notices_, SizeIs(openings));
    bus_->handle_lost(now_);
    bus_->handle_opened(now_);
    drain();
  }
}

TEST_F(BusQuality, ForeignIsNotADeviceThatHasOwedAnAnswerLately) {
  open(settings());
  advance(11s);
  ask();
  rest();  // its quarantine is over
  advance(5s);
  line(kAnswer);
  advance(50ms);
  line(kAnswer);
  advance(50ms);
  EXPECT_EQ(bus_->counters().foreign_frames, 0U);
}

TEST_F(BusQuality, ARequestHeardIsForeignAtOnce) {
  open(settings());
  advance(11s);
  ask();
  rest();
  line("01 03 00 10 00 01 85 CF");
  EXPECT_THAT(notices_, ElementsAre(Notice::foreign));
  EXPECT_TRUE(last_notice_.is_request);
}

TEST_F(BusQuality, ADeniedEchoIsToldOnceThoughAReadWithoutOneClearsIt) {
  auto denying = settings();
  denying.line.echo = false;
  open(denying);
  for (const std::string echo : {kReadFrame, kReadFrame, "", kReadFrame, kReadFrame}) {
    ask();
    line(echo);
    advance(10ms);
    line(kAnswer);
    EXPECT_EQ(bus_->diagnosis().echo() == bus::NoticedEcho::denied, endings_.size() % 3 == 2);
    rest();
  }
  EXPECT_THAT(endings_, SizeIs(5));
  EXPECT_THAT(faults_, ElementsAre(bus::LineFault::echo_denied));
}

// The first ones may be answers to somebody who had the line before.
TEST_F(BusQuality, OnANewLineTheThirdSecondAnswerIsTold) {
  open(settings());
  for (int times = 0; times < 3; ++times) {
    EXPECT_THAT(notices_, IsEmpty());
    ask();
    line(kAnswer);
    advance(5ms);
    line(kAnswer);
    rest();
  }
  EXPECT_THAT(notices_, ElementsAre(Notice::second_answer));
}

TEST_F(BusQuality, ASecondAnswerIsNoOtherClient) {
  open(settings());
  advance(11s);
  ask();
  line(kAnswer);
  advance(5ms);
  line(kAnswer);
  EXPECT_THAT(notices_, ElementsAre(Notice::second_answer));
  EXPECT_EQ(bus_->counters().foreign_frames, 0U);
}

}  // namespace
}  // namespace mbgate::test
