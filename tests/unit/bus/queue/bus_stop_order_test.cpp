// SPDX-License-Identifier: Apache-2.0
// Stops among writes and among each other.
#include "stop_axis.hpp"
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

constexpr auto kStopBy16Frame = "01 10 00 7C 00 01 02 00 E1 6D E4";
constexpr auto kReadOfThirdFrame = "03 03 00 00 00 01 85 E8";

class BusStopOrder : public Bus {
 protected:
  /// A response of a second is waited for.
  static bus::BusSettings slow() {
    auto slow = settings();
    slow.timing.response_timeout = 1s;
    return slow;
  }
  /// For longer than t3.5 after a missing answer nothing but a stop goes.
  void open_settling() {
    auto settling = settings();
    settling.settle = 10ms;
    open(settling, {axis(settling), axis(settling, 2)});
  }
  void answer_after(Duration time, std::string_view bytes) {
    advance(time);
    line(bytes);
  }
};

TEST_F(BusStopOrder, AStopThatRunsHasItsWholeTimeFromTheEndOfItsRequestOn) {
  auto creeping = slow();
  creeping.line.baud = modbus::Baud{1200};
  open(creeping, {axis(creeping, 1), axis(creeping, 3)});
  constexpr auto kLongEmission = 73333334ns;  // 88 bits, rounded up
  advance(40ms);
  submit(job_of(9, kRead, 2));
  submit(job(kStop));
  EXPECT_EQ(until_next_frame(kLongEmission + 100ms), kLongEmission + 100ms);
  submit(job_of(1, kStop, 3));
  EXPECT_EQ(until_next_frame(kLongEmission + 100ms), kLongEmission + 100ms);
  EXPECT_THAT(frames_, SizeIs(3));
}

TEST_F(BusStopOrder, AFailsafeWriteTakesBackWhatWaitsForItsDevice) {
  drive::Device plain{"plain", {}, 1, settings().timing};
  open(settings(), {plain});
  submit(job_of(9, kRead, 2));
  bus::Job& move = job_of(1, kMove);
  submit(move);
  bus::Job& failsafe = job("06 0001 0000");
  failsafe.job_class = bus::JobClass::stop;
  submit(failsafe);
  EXPECT_FALSE(move.is_waiting());
}

TEST_F(BusStopOrder, EveryFrameOfAStopGoesLikeTheFirst) {
  auto slow = settings();
  slow.listen_first = 1s;
  slow.turnaround = 20ms;
  bus_.emplace(slow, std::vector{axis(slow)});
  bus_->start();
  bus_->handle_opened(now_);
  drain();
  bus::Job& stop = job(kStop, 0);
  add(stop, kStop, 129);
  stop.transactions.back().broadcast = drive::BroadcastForm{129, 0x80};
  stop.deadline = now_ + 5ms;
  submit(stop);
  advance(kT35 + kEmission + 20ms + kEmission);
  EXPECT_THAT(frames_, SizeIs(2));
  EXPECT_THAT(endings_, ElementsAre(Ending::transmitted));
}

TEST_F(BusStopOrder, OneThatWaitedForTheTryOfAnotherToItsDriveGivesWayToo) {
  open_settling();
  submit(job(kStop));
  submit(job(kStopBy16));
  submit(job_of(1, kRead, 3));
  advance(120ms);
  EXPECT_THAT(frames_, ElementsAre(kStopFrame, kReadOfThirdFrame));
  refuse(3);
  advance(10ms);
  EXPECT_EQ(frames_.back(), kStopBy16Frame);
}

// What came is damaged, but the drive is there.
TEST_F(BusStopOrder, OneWhoseDriveWasHeardGivesWayToNobody) {
  open_settling();
  submit(job(kStop));
  advance(kEmission + 103ms);
  ASSERT_THAT(frames_, ElementsAre(kStopFrame, kStopFrame));
  submit(job_of(1, kRead, 3));
  answer_after(10ms, "01 06 00 7C 00 E1 00 00");
  advance(30ms);
  EXPECT_THAT(frames_, ElementsAre(kStopFrame, kStopFrame, kStopFrame));
}

// The first read was on its way before anybody knew that the drive is dead.
TEST_F(BusStopOrder, BetweenTwoTriesToADeadDriveWhatHasSeveralPartsGoesOn) {
  open_settling();
  bus::Job& run = job_of(1, kRead, 3);
  add(run, "03 0001 0001", 3);
  submit(run);
  submit(job(kStop));
  answer_after(10ms, "03 03 02 12 34 CC F3");
  advance(kT35 + kEmission + 115ms);
  EXPECT_THAT(frames_, ElementsAre(kReadOfThirdFrame, kStopFrame, "03 03 00 01 00 01 D4 28"));
}

TEST_F(BusStopOrder, ADriveThatHasLostOneAnswerStillAnswers) {
  for (const bool is_dead : {false, true}) {
    frames_.clear();
    open_settling();
    submit(job_of(1, kRead));
    answer_after(10ms, kAnswer);
    for (int times = 0; times < (is_dead ? 2 : 1); ++times) {
      submit(job_of(1, kRead));
      advance(300ms);
    }
    submit(job_of(9, kRead, 3));
    frames_.clear();
    submit(job(kStop));
    submit(job(kStop, 2));
    refuse(3);
    advance(10ms);
    EXPECT_EQ(frames_.at(0), is_dead ? "02 06 00 7C 00 E1 88 69" : kStopFrame);
  }
}

TEST_F(BusStopOrder, NothingGoesBeforeTheRepetitionToADriveThatAnsweredBefore) {
  open_settling();
  submit(job_of(1, kRead));
  answer_after(10ms, kAnswer);
  submit(job(kStop));
  advance(10ms);
  submit(job_of(1, kRead, 2));
  advance(130ms);
  EXPECT_THAT(frames_, ElementsAre(kReadFrame, kStopFrame, kStopFrame));
}

TEST_F(BusStopOrder, SoDoThoseToTwoDeadDrives) {
  open_settling();
  submit(job(kStop));
  submit(job(kStop, 2));
  submit(job_of(1, kRead, 3));
  advance(230ms);
  EXPECT_THAT(frames_, ElementsAre(kStopFrame, "02 06 00 7C 00 E1 88 69", kReadOfThirdFrame));
}

}  // namespace
}  // namespace mbgate::test
