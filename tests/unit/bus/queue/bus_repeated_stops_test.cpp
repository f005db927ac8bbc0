// SPDX-License-Identifier: Apache-2.0
// A stop that only repeats an acknowledged one lets others have the line too.
#include "unit/bus/bus_rig.hpp"
#include "unit/bus/queue/stop_axis.hpp"

namespace mbgate::test::bus_repeated_stops_test {
namespace {

constexpr auto kReadOf2 = "02 03 00 00 00 01 84 39";
constexpr auto kAnswerOf2 = "02 03 02 12 34 F1 33";

class BusRepeatedStops : public Bus {
 protected:
  void open_axes(const bus::BusSettings& settings) {
    drive::Device first = axis(settings);
    first.profile.stops.push_back({.address = 0x0080, .mask = 0xFFF0, .value = 0x0010});
    drive::Device other = axis(settings, 2);
    other.name = "other";
    open(settings, {first, other});
  }
  /// The request goes, and its echo is the answer.
  void is_done(bus::Job& write) {
    submit(write);
    advance(10ms);
    line(frames_.back());
  }
  /// A read and a stop wait behind a stop of another axis.
  void wait_behind_another_stop(std::string_view stop = kStop) {
    submit(job_of(1, kStop, 2));
    advance(10ms);
    submit(job_of(1, kRead, 2));
    submit(job_of(2, stop));
    line(frames_.back());
    advance(5ms);
  }
};

TEST_F(BusRepeatedStops, WhatTheSameClientAsksOfTheDeviceAfterwardsIsSentAfterwards) {
  open_axes(settings());
  submit(job(kStop));
  submit(job(kStop));  // joins it no more, as it is on the wire
  submit(job(kMove));
  for (int answers = 0; answers < 2; ++answers) {
    advance(10ms);
    line(frames_.back());
  }
  advance(100ms);
  EXPECT_THAT(frames_, ElementsAre(kStopFrame, kStopFrame, kMoveFrame));
}

TEST_F(BusRepeatedStops, AStopGoesFirst) {
  open_axes(settings());
  wait_behind_another_stop();
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusRepeatedStops, OneThatRepeatsAnAcknowledgedOneLetsOneTransactionGo) {
  open_axes(settings());
  is_done(job(kStop));
  wait_behind_another_stop();
  EXPECT_EQ(frames_.back(), kReadOf2);
  submit(job_of(1, kRead, 2));
  line(kAnswerOf2);
  advance(5ms);
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusRepeatedStops, GoAtOnceIfNothingElseWaits) {
  open_axes(settings());
  is_done(job(kStop));
  is_done(job(kStop));
  EXPECT_THAT(frames_, ElementsAre(kStopFrame, kStopFrame));
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

// Whoever may only send stops would have the line for themselves, and its drive in any case.
TEST_F(BusRepeatedStops, WithoutAPauseLeaveHalfOfTheTransactionsToOthers) {
  for (const std::uint8_t address : {std::uint8_t{1}, std::uint8_t{2}}) {
    open_axes(settings());
    submit(job(kStop));
    advance(8ms);
    line(kStopFrame);
    submit(job(kStop));
    submit(job_of(1, kRead, address));
    const auto served = this->served(2s, [&] {
      const bool is_stop = frames_.back() == kStopFrame;
      submit(is_stop ? job(kStop) : job_of(1, kRead, address));
      advance(8ms);
      line(is_stop ? kStopFrame : address == 1 ? kAnswer : kAnswerOf2);
      return is_stop ? 1 : 0;
    });

    ASSERT_GT(served.size(), 50U);
    EXPECT_LE(std::abs(std::ranges::count(served, 0) - std::ranges::count(served, 1)), 1);
  }
}

TEST_F(BusRepeatedStops, GoFirstAgainAfterASecond) {
  open_axes(settings());
  is_done(job(kStop));
  advance(1s);
  wait_behind_another_stop();
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusRepeatedStops, GoFirstAgainBehindAWrite) {
  open_axes(settings());
  is_done(job(kStop));
  is_done(job_of(1, kMove));
  wait_behind_another_stop();
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusRepeatedStops, GoFirstAgainBehindAWriteThatWasAcceptedWhileTheFirstOneWasOnTheWire) {
  open_axes(settings());
  submit(job(kStop));
  advance(5ms);
  submit(job_of(1, kMove));
  line(kStopFrame);
  advance(10ms);
  ASSERT_EQ(frames_.back(), kMoveFrame);
  line(kMoveFrame);
  wait_behind_another_stop();
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusRepeatedStops, GoFirstAgainBehindABroadcastThatIsNoStop) {
  open_axes(settings());
  is_done(job(kStop));
  submit(job_of(1, kMove, 0));
  advance(300ms);
  wait_behind_another_stop();
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusRepeatedStops, GoFirstAgainIfARequestToTheDeviceIsNotAnswered) {
  open_axes(settings());
  is_done(job(kStop));
  submit(job_of(1, kRead));
  time_out();
  wait_behind_another_stop();
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusRepeatedStops, AnotherStopOfTheDeviceGoesFirst) {
  open_axes(settings());
  is_done(job(kStop));
  wait_behind_another_stop("06 0080 0011");
  EXPECT_EQ(frames_.back().substr(0, 17), "01 06 00 80 00 11");
}

TEST_F(BusRepeatedStops, ThatAreAllDifferentGoFirstEightTimesASecond) {
  open_axes(settings());
  for (const auto value : {"10", "11", "12", "13", "14", "15", "16"}) {
    is_done(job(std::string("06 0080 00") + value));
  }
  wait_behind_another_stop("06 0080 0017");
  EXPECT_EQ(frames_.back().substr(0, 17), "01 06 00 80 00 17");
  line(frames_.back());
  advance(5ms);
  EXPECT_EQ(frames_.back(), kReadOf2);
  line(kAnswerOf2);
  wait_behind_another_stop("06 0080 0018");
  EXPECT_EQ(frames_.back(), kReadOf2);
}

TEST_F(BusRepeatedStops, CutNoRunningTransaction) {
  auto slow = settings();
  slow.timing.response_timeout = 1s;
  open_axes(slow);
  is_done(job(kStop));
  submit(job_of(1, kRead, 2));
  advance(10ms);
  submit(job_of(2, kStop));
  advance(300ms);
  EXPECT_EQ(frames_.back(), kReadOf2);
  line(kAnswerOf2);
  advance(5ms);
  EXPECT_EQ(frames_.back(), kStopFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

TEST_F(BusRepeatedStops, AreRepeatedLikeAnyStopIfNobodyAnswers) {
  open_axes(settings());
  is_done(job(kStop));
  submit(job(kStop));
  advance(600ms);
  EXPECT_THAT(frames_, SizeIs(1U + 4U));
}

TEST_F(BusRepeatedStops, OfABroadcastCountOnceItWasSent) {
  open_axes(settings());
  submit(job(kStop, 0));
  advance(300ms);
  submit(job_of(1, kStop, 2));
  advance(10ms);
  submit(job_of(1, kRead, 2));
  submit(job(kStop, 0));
  line(frames_.back());
  advance(5ms);
  EXPECT_EQ(frames_.back(), kReadOf2);
}

}  // namespace
}  // namespace mbgate::test::bus_repeated_stops_test
