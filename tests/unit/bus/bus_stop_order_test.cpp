// SPDX-License-Identifier: Apache-2.0
// Stops among writes and among each other.
#include "bus_rig.hpp"
#include "bus_tcp_rig.hpp"

namespace mbgate::test {
namespace {

constexpr auto kStop = "06 007C 00E1";
constexpr auto kStopFrame = "01 06 00 7C 00 E1 88 5A";
constexpr auto kMove = "06 007C 0066";
constexpr auto kMoveFrame = "01 06 00 7C 00 66 C8 38";

drive::Device axis(const bus::BusSettings& settings, std::uint8_t address = 1) {
  drive::Device device{"axis", {}, address, settings.timing};
  device.profile.stops = {{.address = 0x007C, .value = 0x00E1}};
  return device;
}

class BusStopOrder : public Bus {
 protected:
  void open_patient() {
    auto patient = axis(settings());
    patient.stop_cancels = false;
    open(settings(), {patient});
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

TEST_F(BusStopOrder, ARepeatedStopHasAsMuchTimeAsTheFirst) {
  open(settings(), {axis(settings(), 1), axis(settings(), 2), axis(settings(), 3)});
  for (const auto address : {1, 2, 3}) {
    submit(job_of(static_cast<std::uint32_t>(address), kStop, static_cast<std::uint8_t>(address)));
  }
  advance(2s);
  ASSERT_THAT(frames_, SizeIs(12));
  for (std::size_t at = 1; at < 12; ++at) {
    EXPECT_GE(frame_times_[at] - frame_times_[at - 1], 100ms) << at;
  }
}

TEST_F(BusTcp, AStopCutsOffOnlyWhatIsInItsWay) {
  auto slow = tcp(2);
  slow.timing.response_timeout = 1s;
  open(slow, {axis(slow, 3)});
  submit(job_of(0, kRead, 1));
  submit(job_of(1, kRead, 2));
  submit(job_of(2, kStop, 3));
  advance(100ms);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(BusTcp, ALateAnswerBringsItsDeviceBack) {
  auto breaking = tcp(1);
  breaking.timing.offline_after = 1;
  open(breaking);
  submit(job(kRead, 1));
  advance(breaking.timing.response_timeout);
  EXPECT_TRUE(bus_->is_offline(1));
  answer(0, "01 03 02 12 34");
  EXPECT_FALSE(bus_->is_offline(1));
  EXPECT_EQ(bus_->counters().late_responses, 1U);
}

}  // namespace
}  // namespace mbgate::test
