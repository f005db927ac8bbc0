// SPDX-License-Identifier: Apache-2.0
// Stops go next, take back what they stop, and are repeated until they are acknowledged.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test::bus_stops_test {
namespace {

using Kind = bus::DeviceNotice::Kind;

constexpr auto kStop = "06 007C 00E1";
constexpr auto kStopFrame = "01 06 00 7C 00 E1 88 5A";
constexpr auto kMove = "06 007C 0066";

class BusStops : public Bus {
 protected:
  static drive::Device moons(std::uint8_t address = 1) {
    drive::Device device{"axis", {}, address, settings().timing};
    device.profile.stops = {{.address = 0x007C, .value = 0x00E1}};
    return device;
  }
  void open_with(const drive::Device& device) { open(settings(), {device}); }
  [[nodiscard]] std::size_t stops_sent() const {
    return static_cast<std::size_t>(std::ranges::count(frames_, kStopFrame));
  }
};

TEST_F(BusStops, AStopGoesNextBeforeEverythingThatWaits) {
  open_with(moons());
  submit(job_of(1, kRead, 2));
  for (int times = 0; times < 20; ++times) {
    submit(job_of(1, kRead, 3));
    submit(job_of(2, "06 0000 0001", 4));
  }
  advance(10ms);
  submit(job(kStop));
  line("02 03 02 12 34 F1 33");
  advance(5ms);
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(frames_[1], kStopFrame);
}

TEST_F(BusStops, AResponseThatHasBegunIsHeardOut) {
  open_with(moons());
  submit(job("03 0000 0010", 2));
  advance(20ms);
  submit(job_of(1, kStop));
  advance(70ms);
  line("02 03 20");
  advance(35ms);
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(BusStops, AnExceptionThatMayBeOwedToAnotherIsNoAnswerToAStop) {
  open_with(moons());
  submit(job_of(1, kMove));
  time_out();
  submit(job(kStop));
  advance(10ms);
  line("01 86 04 43 A3");  // says no to the move, too late
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  advance(10ms);
  line(kStopFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
}

TEST_F(BusStops, WritesToTheSameDeviceThatWaitAreTakenBack) {
  open_with(moons());
  submit(job_of(1, kRead, 2));
  bus::Job& move = job_of(2, kMove);
  bus::Job& other = job_of(2, kMove, 3);
  bus::Job& read = job_of(3, kRead);
  submit(move);
  submit(other);
  submit(read);
  submit(job(kStop));
  EXPECT_FALSE(move.is_waiting());
  EXPECT_FALSE(move.was_on_wire);
  EXPECT_TRUE(other.is_waiting());
  EXPECT_TRUE(read.is_waiting());
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled));
  EXPECT_EQ(bus_->counters().overtaken_writes, 1U);
}

// Whatever else is stopped.
TEST_F(BusStops, OfAWriteInPartsNoFurtherPartIsSent) {
  open(settings(), {moons(1), moons(2)});
  bus::Job& run = job(kMove);
  add(run, "06 0001 0001");
  submit(run);
  advance(10ms);
  submit(job_of(1, kStop));
  submit(job_of(1, kStop, 2));
  line("01 06 00 7C 00 66 C8 38");
  advance(5ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled));
  EXPECT_TRUE(run.was_on_wire);
  EXPECT_THAT(frames_, ElementsAre("01 06 00 7C 00 66 C8 38", kStopFrame));
}

TEST_F(BusStops, AStopIsRepeatedUntilItIsAcknowledged) {
  open_with(moons());
  submit(job(kStop));
  advance(1s);
  EXPECT_EQ(stops_sent(), 4U);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_THAT(notices_, ElementsAre(Kind::stop_unanswered));
  EXPECT_EQ(bus_->counters().stops, 4U);
  EXPECT_EQ(bus_->counters().stops_unanswered, 1U);
}

TEST_F(BusStops, AStopIsNotRepeatedOnceAcknowledged) {
  open_with(moons());
  submit(job(kStop));
  advance(110ms);
  line(kStopFrame);
  advance(1s);
  EXPECT_EQ(stops_sent(), 2U);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusStops, AWriteThatIsSentAsAStopIsRepeatedAsOneIs) {
  open_with(moons());
  bus::Job& failsafe = job(kMove);
  failsafe.job_class = bus::JobClass::stop;
  submit(failsafe);
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(4));
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(BusStops, IdenticalWaitingStopsAreSentOnce) {
  open_with(moons());
  submit(job_of(1, kRead, 2));
  for (std::uint32_t source = 2; source < 12; ++source) {
    submit(job_of(source, kStop));
  }
  advance(10ms);
  line("02 03 02 12 34 F1 33");
  advance(10ms);
  line(kStopFrame);
  advance(1s);
  EXPECT_EQ(stops_sent(), 1U);
  EXPECT_THAT(endings_, SizeIs(11));
  for (std::size_t at = 1; at < jobs_.size(); ++at) {
    EXPECT_TRUE(jobs_[at].transactions[0].response) << at;
  }
}

TEST_F(BusStops, NeitherQuarantineNorBreakerNorDeadlineHoldsAStop) {
  auto dying = moons();
  dying.timing.offline_after = 1;
  open_with(dying);
  submit(job(kRead));
  time_out();
  EXPECT_TRUE(bus_->devices()[1].health.is_offline());
  EXPECT_GT(bus_->parts().held_back(1, now_), 0ms);
  bus::Job& stop = job(kStop);
  stop.deadline = now_ - 1s;
  submit(stop);
  EXPECT_EQ(stops_sent(), 1U);
  advance(20ms);
  line(kStopFrame);
  EXPECT_FALSE(bus_->devices()[1].health.is_offline());
}

TEST_F(BusStops, ListeningSettlingAndGapDoNotHoldAStopButSilenceDoes) {
  auto slow = settings();
  slow.listen_first = 1s;
  slow.settle = 500ms;
  auto gapped = moons();
  gapped.timing.gap = 200ms;
  bus_.emplace(slow, std::vector{gapped});
  bus_->start();
  bus_->handle_opened(now_);
  drain();
  submit(job(kStop));
  EXPECT_EQ(until_next_frame(), kT35);
}

TEST_F(BusStops, ATurnaroundDelayIsKept) {
  open_with(moons());
  submit(job_of(1, "06 0000 0001", 0));
  advance(kEmission);
  submit(job(kStop));
  EXPECT_EQ(until_next_frame(), 100ms);
}

TEST_F(BusStops, AStopGoesBeforeARetryAndBetweenTheParts) {
  auto retrying = settings();
  retrying.timing.retries = 1;
  open(retrying, {moons()});
  submit(job(kRead, 2));
  advance(kEmission + 99ms);
  submit(job_of(1, kStop));
  advance(10ms);
  line(kStopFrame);
  advance(110ms);  // lost time is paid back
  EXPECT_THAT(frames_,
              ElementsAre("02 03 00 00 00 01 84 39", kStopFrame, "02 03 00 00 00 01 84 39"));
}

TEST_F(BusStops, ABroadcastStopTakesBackTheWritesOfThoseThatHearIt) {
  open_with(moons());
  submit(job_of(1, kRead, 2));
  bus::Job& move = job_of(2, kMove);
  bus::Job& all = job_of(3, "06 0000 0001", 0);
  submit(move);
  submit(all);
  bus::Job& stop = job(kStop, 0);
  submit(stop);
  EXPECT_EQ(stop.job_class, bus::JobClass::stop);
  EXPECT_FALSE(move.is_waiting());
  EXPECT_FALSE(all.is_waiting());
}

// Nobody can keep a drive from listening at address 0, whatever its manual says.
TEST_F(BusStops, AStopTakesBackABroadcastThatItsDriveMayHear) {
  drive::Device deaf = moons();
  deaf.profile.broadcast.form = std::nullopt;
  open_with(deaf);
  submit(job_of(1, kRead, 2));
  bus::Job& all = job_of(2, "06 0000 0001", 0);
  submit(all);
  submit(job(kStop));
  EXPECT_FALSE(all.is_waiting());
}

TEST_F(BusStops, WaitingStopsAreSentWhileTheBusStops) {
  open_with(moons());
  submit(job_of(1, kRead, 2));
  submit(job_of(2, kRead, 3));
  submit(job(kStop));
  bus_->stop(now_);
  drain();
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled));
  advance(10ms);
  line("02 03 02 12 34 F1 33");
  advance(10ms);
  EXPECT_EQ(stops_sent(), 1U);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusStops, ThereIsRoomForStopsInAFullQueue) {
  auto small = settings();
  small.queue = 1;
  open(small, {moons()});
  submit(job_of(1, kRead, 2));
  submit(job_of(1, "06 0000 0001", 3));
  submit(job(kStop));
  EXPECT_TRUE(jobs_.back().accepted);
}

TEST_F(BusStops, TwoDeadDevicesDoNotKeepEachOthersStopsWaiting) {
  auto slow = settings();
  slow.timing.response_timeout = 1s;
  auto one = moons(1);
  auto two = moons(2);
  one.timing = two.timing = slow.timing;
  open(slow, {one, two});
  submit(job(kStop, 1));
  submit(job_of(1, kStop, 2));
  advance(kEmission + 110ms);
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_EQ(unhex(frames_[1])[0], 2);
  advance(5s);
  EXPECT_THAT(frames_, SizeIs(8));
}

}  // namespace
}  // namespace mbgate::test::bus_stops_test
