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
  void open_patient() { open_patient(settings()); }
  void open_patient(const bus::BusSettings& bus) {
    auto patient = axis(bus);
    patient.stop_cancels = false;
    open(bus, {patient});
  }
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

TEST_F(BusStopOrder, AStopBehindAWriteThatIsLetGoIsNotJoinedToOneBeforeIt) {
  open_patient();
  submit(job_of(9, kRead, 2));
  submit(job(kMove));
  submit(job(kStop));
  submit(job("06 0000 0001"));
  submit(job(kStop));
  advance(10ms);
  line("02 03 02 12 34 F1 33");
  for (std::size_t at = 1; at < 5; ++at) {
    advance(10ms);
    ASSERT_THAT(frames_, SizeIs(at + 1));
    line(frames_[at]);
  }
  EXPECT_THAT(frames_, ElementsAre("02 03 00 00 00 01 84 39", kMoveFrame, kStopFrame,
                                   "01 06 00 00 00 01 48 0A", kStopFrame));
}

TEST_F(BusStopOrder, AWriteThatIsLetGoCutsOffWhatRunsAsItsStopWouldAndGoesBeforeRetries) {
  auto retrying = slow();
  retrying.timing.retries = 1;
  open_patient(retrying);
  submit(job_of(9, kRead, 2));
  advance(20ms);
  submit(job(kMove));
  submit(job(kStop));
  EXPECT_EQ(until_next_frame(kEmission + 80ms), kEmission + 80ms);
  EXPECT_EQ(frames_.back(), kMoveFrame);
  EXPECT_EQ(until_next_frame(kEmission + 100ms), kEmission + 100ms);
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusStopOrder, AWriteThatIsLetGoHasItsOwnTimeForAnAnswer) {
  open_patient(slow());
  submit(job_of(9, kRead, 2));
  advance(20ms);
  submit(job(kMove));
  submit(job(kStop));
  advance(kEmission + 80ms);
  answer_after(kEmission + 99ms, kMoveFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
  EXPECT_EQ(until_next_frame(), kT35);
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusStopOrder, AWriteThatIsLetGoHoldsItsStopNoLongerThanStopWait) {
  open_patient(slow());
  submit(job(kMove));
  submit(job(kStop));
  EXPECT_EQ(until_next_frame(), kEmission + 100ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(BusStopOrder, AWriteThatCannotGoInTimeIsTakenBackAtOnce) {
  auto quarantined = settings();
  quarantined.timing.quarantine = 300ms;
  open_patient(quarantined);
  submit(job(kRead));
  time_out();
  bus::Job& move = job(kMove);
  submit(move);
  submit(job(kStop));
  EXPECT_EQ(frames_.back(), kStopFrame);
  EXPECT_FALSE(move.was_on_wire);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::cancelled));
}

TEST_F(BusStopOrder, AWriteThatIsHeldBackForAShortTimeIsWaitedForAndNothingElseBegins) {
  auto gapped = settings();
  gapped.timing.gap = 50ms;
  open_patient(gapped);
  submit(job(kMove));
  submit(job(kStop));
  submit(job_of(9, kRead, 2));
  EXPECT_EQ(until_next_frame(60ms), 47005209ns);  // open for 5 ms, and t3.5
  EXPECT_EQ(frames_.back(), kMoveFrame);
  answer_after(0ms, kMoveFrame);
  EXPECT_EQ(until_next_frame(60ms), kT35);
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusStopOrder, WritesThatAreHeldBackHoldAStopNoLongerThanStopWaitInAll) {
  auto gapped = settings();
  gapped.timing.gap = 60ms;
  open_patient(gapped);
  for (int times = 0; times < 3; ++times) {
    submit(job(kMove));
  }
  submit(job(kStop));
  advance(60ms);
  ASSERT_THAT(frames_, ElementsAre(kMoveFrame));
  answer_after(10ms, kMoveFrame);
  EXPECT_EQ(until_next_frame(60ms), kT35);
  EXPECT_EQ(frames_.back(), kStopFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::cancelled, Ending::cancelled));
}

TEST_F(BusStopOrder, ForHowLongAnotherDeviceWasWaitedForIsNoHoldOfTheWrites) {
  auto settling = slow();
  settling.settle = 60ms;
  open_patient(settling);
  submit(job_of(9, kRead, 2));
  submit(job(kMove));
  submit(job(kStop));
  EXPECT_EQ(until_next_frame(kEmission + 160ms),
            kEmission + 160ms);  // stop_wait, and then only `settle`
  EXPECT_EQ(frames_.back(), kMoveFrame);
  answer_after(10ms, kMoveFrame);
  EXPECT_EQ(until_next_frame(60ms), kT35);
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusStopOrder, OfARunThatIsHeldBackTooLongNoFurtherPartIsSent) {
  auto gapped = settings();
  gapped.timing.gap = 200ms;
  open_patient(gapped);
  bus::Job& run = job(kMove);
  add(run, "06 0001 0001");
  submit(run);
  advance(210ms);
  submit(job_of(1, kStop));
  line(kMoveFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled));
  EXPECT_TRUE(run.was_on_wire);
  advance(10ms);
  EXPECT_THAT(frames_, ElementsAre(kMoveFrame, kStopFrame));
}

TEST_F(BusStopOrder, WhatCameBehindAStopIsNotTakenBackWithTheWritesBeforeIt) {
  auto gapped = settings();
  gapped.timing.gap = 60ms;
  open_patient(gapped);
  submit(job(kMove));
  submit(job_of(1, kMove));
  submit(job(kStop));
  bus::Job& later = job(kMove);
  submit(later);
  advance(60ms);
  answer_after(10ms, kMoveFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::cancelled));
  EXPECT_TRUE(later.is_waiting());
}

TEST_F(BusStopOrder, ABroadcastIsAWriteThatIsLetGo) {
  open_patient();
  submit(job_of(9, kRead, 2));
  submit(job_of(1, "06 0000 0001", 0));
  submit(job(kStop));
  answer_after(10ms, "02 03 02 12 34 F1 33");
  EXPECT_EQ(until_next_frame(10ms), kT35);
  EXPECT_EQ(unhex(frames_.back())[0], 0);
  EXPECT_EQ(until_next_frame(), kEmission + 100ms - (10ms - kT35));  // the turnaround delay
  EXPECT_EQ(frames_.back(), kStopFrame);
}

TEST_F(BusStopOrder, ABroadcastThatWaitsForOthersIsTakenBack) {
  open_patient();
  submit(job_of(9, kRead, 2));
  submit(job_of(1, kRead, 3));
  submit(job_of(1, "06 0000 0001", 0));
  submit(job(kStop));
  answer_after(10ms, "02 03 02 12 34 F1 33");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::cancelled));
  EXPECT_EQ(until_next_frame(), kT35);
  EXPECT_EQ(frames_[1], kStopFrame);
}

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

TEST_F(BusStopOrder, WhatItLetsGoIsTakenBackOnceTheSettingsSaySo) {
  open_patient();
  submit(job_of(9, kRead, 2));
  bus::Job& move = job(kMove);
  submit(move);
  submit(job(kStop));
  bus::Job& later = job("06 0000 0001");
  submit(later);
  const drive::Device impatient = axis(settings());
  update(settings(), {impatient});
  EXPECT_FALSE(move.is_waiting());
  EXPECT_TRUE(later.is_waiting());
}

TEST_F(BusStopOrder, ABroadcastStopTakesBackEvenWhatWouldBeLetGo) {
  open_patient();
  submit(job_of(9, kRead, 2));
  bus::Job& move = job(kMove);
  submit(move);
  submit(job(kStop, 0));
  EXPECT_FALSE(move.is_waiting());
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
  stop.transactions.back().broadcast = drive::BroadcastForm::autonics;
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
