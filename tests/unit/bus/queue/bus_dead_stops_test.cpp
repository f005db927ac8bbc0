// SPDX-License-Identifier: Apache-2.0
// Stops that nobody answers, and lines that are never silent.
#include "stop_axis.hpp"
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

using Kind = bus::DeviceNotice::Kind;

class BusDeadStops : public Bus {
 protected:
  static bus::BusSettings breaking() {
    auto breaking = settings();
    breaking.timing.offline_after = 3;
    return breaking;
  }
  void open_axis(const bus::BusSettings& settings) {
    open(settings, {axis(settings, 1), axis(settings, 2), axis(settings, 3)});
  }
  [[nodiscard]] std::size_t stops_sent() const {
    return static_cast<std::size_t>(std::ranges::count(frames_, kStopFrame));
  }
  /// A whole series of tries was in vain, and the device is offline.
  void give_up_axis() {
    submit(job(kStop));
    advance(600ms);
    EXPECT_EQ(stops_sent(), 4U);
    EXPECT_TRUE(bus_->devices()[1].health.is_offline());
    frames_.clear();
    endings_.clear();
  }
  /// Bytes without a silence.
  void babble(Duration duration) {
    for (const Instant end = now_ + duration; now_ < end;) {
      advance(1ms);
      line("55");
    }
  }
};

TEST_F(BusDeadStops, BetweenTwoTriesAnotherDeviceHasOneTurn) {
  open_axis(settings());
  submit(job(kStop));
  submit(job_of(1, kRead, 2));
  submit(job_of(2, kRead, 3));
  advance(110ms);
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(unhex(frames_[1])[0], 2);
  refuse(2);
  advance(10ms);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2], kStopFrame);
  advance(110ms);
  ASSERT_THAT(frames_, SizeIs(4));
  EXPECT_EQ(unhex(frames_[3])[0], 3);
}

TEST_F(BusDeadStops, ThatTurnHasStopWaitForItsAnswer) {
  auto slow = settings();
  slow.timing.response_timeout = 1s;
  open_axis(slow);
  submit(job(kStop));
  submit(job_of(1, kRead, 2));
  advance(1100ms);
  ASSERT_THAT(frames_, SizeIs(2));
  advance(100ms);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frame_times_[2] - frame_times_[1], kEmission + 100ms);
}

TEST_F(BusDeadStops, TheFirstSeriesToAnOfflineDeviceWaitsForItsWholeTimeout) {
  auto slow = breaking();
  slow.timing.response_timeout = 500ms;
  open_axis(slow);
  for (int times = 0; times < 3; ++times) {
    submit(job(kRead));
    advance(2s);
  }
  ASSERT_TRUE(bus_->devices()[1].health.is_offline());
  submit(job(kStop));
  advance(kEmission + 450ms);
  EXPECT_EQ(stops_sent(), 1U);
  line(kStopFrame);
  EXPECT_EQ(endings_.back(), Ending::answered);
}

TEST_F(BusDeadStops, WithNobodyElseWaitingAStopIsRepeatedAtOnce) {
  open_axis(settings());
  submit(job(kStop));
  advance(3 * (kEmission + 100ms));
  EXPECT_EQ(stops_sent(), 4U);
}

TEST_F(BusDeadStops, AStopThatWasAnsweredGivesWayToNobody) {
  open_axis(settings());
  submit(job(kStop));
  advance(10ms);
  line(kStopFrame);
  submit(job_of(1, kRead, 2));
  advance(10ms);
  submit(job(kStop));
  submit(job_of(2, kRead, 3));
  refuse(2);
  advance(10ms);
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusDeadStops, ToADeadDriveThatWasGivenUpAStopIsTriedOnce) {
  open_axis(breaking());
  give_up_axis();
  submit(job(kStop));
  advance(1s);
  EXPECT_EQ(stops_sent(), 1U);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(bus_->counters().probes, 0U);
}

TEST_F(BusDeadStops, ADriveThatWasHeardInASeriesIsNotGivenUp) {
  open_axis(settings());
  for (const std::size_t series : {1U, 2U}) {
    submit(job(kStop));
    advance(20ms);
    line("01 06 00 7C 00 E1 00 00");  // damaged
    advance(600ms);
    EXPECT_EQ(stops_sent(), 4 * series);
  }
}

TEST_F(BusDeadStops, AndCutsNothingThatRuns) {
  auto slow = breaking();
  slow.timing.response_timeout = 1s;
  open_axis(slow);
  submit(job(kStop));
  advance(5s);
  EXPECT_TRUE(bus_->devices()[1].health.is_offline());
  endings_.clear();
  submit(job_of(1, kRead, 2));
  submit(job(kStop));
  advance(600ms);
  EXPECT_THAT(endings_, IsEmpty());
  refuse(2);
  advance(5ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusDeadStops, OnceItAnswersAgainStopsAreRepeatedAgain) {
  open_axis(breaking());
  give_up_axis();
  submit(job(kStop));
  advance(10ms);
  line(kStopFrame);
  submit(job(kStop));
  advance(1s);
  EXPECT_EQ(stops_sent(), 1U + 4U);
}

TEST_F(BusDeadStops, AStopInEveryScanToADeadDriveLeavesTheOthersTheBus) {
  auto usual = settings();
  usual.timing = {};
  open_axis(usual);
  unsigned answered = 0;
  bus::Job* read = nullptr;
  for (int at = 0; at < 3000; ++at) {  // 30 s
    if (at % 25 == 0) {
      submit(job_of(1, kStop));
    }
    if (read == nullptr || !read->accepted) {
      read = &job_of(2, kRead, 2);
      submit(*read);
    }
    advance(10ms);
    if (read->sent.in_flight) {
      line("02 03 02 12 34 F1 33");
      answered += read->accepted ? 0U : 1U;
    }
  }
  EXPECT_GT(answered, 300U);
}

TEST_F(BusDeadStops, OnALineThatIsNeverSilentAStopGoesAtItsDeadline) {
  open_axis(settings());
  advance(1s);
  babble(10ms);
  submit(job(kStop));
  const Instant since = now_;
  babble(1900ms);
  EXPECT_THAT(frames_, IsEmpty());
  babble(200ms);
  ASSERT_EQ(stops_sent(), 1U);
  EXPECT_EQ(frame_times_[0] - since, 2s);
  EXPECT_THAT(notices_, ElementsAre(Kind::stop_forced));
  babble(3s);
  EXPECT_EQ(stops_sent(), 1U);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(BusDeadStops, StopsToOthersWithoutEndKeepItWaitingForOneOfThem) {
  open_axis(settings());
  submit(job(kStop));
  advance(1ms);
  submit(job(kStop, 2));
  time_out();
  for (int times = 0; times < 4; ++times) {
    advance(5ms);
    submit(job(kStop, 2));
    line("02 06 00 7C 00 E1 88 69");
  }
  EXPECT_GE(stops_sent(), 2U);
}

// The first one was tried and is not repeated on such a line; the second one joined it since then,
// and keeps its place among the others.
TEST_F(BusDeadStops, AnIdenticalOneThatWasNotTriedYetGoesAtADeadlineOfItsOwn) {
  open_axis(settings());
  babble(10ms);
  submit(job(kStop));
  babble(2200ms);
  ASSERT_EQ(stops_sent(), 1U);
  const Instant since = now_;
  submit(job_of(1, kStop));
  submit(job_of(2, kStop));
  submit(job(kStop, 2));
  babble(2s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  babble(200ms);
  ASSERT_EQ(stops_sent(), 2U);
  EXPECT_EQ(frame_times_[1] - since, 2s);
  babble(6s);
  EXPECT_EQ(endings_, std::vector(4, Ending::no_answer));
  EXPECT_THAT(frames_, ElementsAre(kStopFrame, kStopFrame, "02 06 00 7C 00 E1 88 69"));
}

TEST_F(BusDeadStops, AtItsDeadlineItWaitsForNobodyElsesTurn) {
  open_axis(breaking());
  give_up_axis();
  babble(10ms);
  submit(job(kStop));
  submit(job_of(1, kRead, 2));
  const Instant since = now_;
  babble(1s);
  submit(job(kStop, 2));  // which does not give way
  babble(1100ms);
  ASSERT_EQ(stops_sent(), 1U);
  EXPECT_LE(frame_times_[0] - since, 2s + 1ms);
}

TEST_F(BusDeadStops, ItsRepetitionsUseTheFirstSilence) {
  open_axis(settings());
  advance(1s);
  babble(10ms);
  submit(job(kStop));
  babble(2500ms);
  ASSERT_EQ(stops_sent(), 1U);
  advance(3ms);
  EXPECT_EQ(stops_sent(), 2U);
  advance(10ms);
  line(kStopFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusDeadStops, OnlyTheTimeWithoutSilenceCounts) {
  auto patient = settings();
  patient.stop_deadline = 500ms;
  open_axis(patient);
  babble(450ms);
  submit(job(kStop));
  babble(450ms);
  EXPECT_THAT(frames_, IsEmpty());
  advance(kT35);
  EXPECT_EQ(stops_sent(), 1U);
  EXPECT_THAT(notices_, IsEmpty());
}

TEST_F(BusDeadStops, ALineThatIsNeverSilentIsReportedOnceEachTimeItIsOpen) {
  open_axis(settings());
  babble(900ms);
  advance(10ms);
  babble(990ms);
  EXPECT_EQ(never_silent_, 0U);
  babble(3s);
  EXPECT_EQ(never_silent_, 1U);
  bus_->handle_lost(now_);
  bus_->handle_opened(now_);
  babble(3s);
  EXPECT_EQ(never_silent_, 2U);
}

}  // namespace
}  // namespace mbgate::test
