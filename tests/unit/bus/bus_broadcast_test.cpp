// SPDX-License-Identifier: Apache-2.0
// Broadcasts in the forms that the devices of a bus hear.
#include "bus_rig.hpp"
#include "unit/bus/queue/stop_axis.hpp"

namespace mbgate::test {
namespace {

using testing::StartsWith;

class BusBroadcast : public Bus {
 protected:
  /// One write in both forms.
  bus::Job& both_forms(std::string_view request) {
    bus::Job& made = job(request, 0);
    add(made, request, 129);
    made.transactions[1].broadcast = drive::BroadcastForm{129, 0x80};
    return made;
  }
};

TEST_F(BusBroadcast, KeepsTheTurnaroundDelayAfterEachForm) {
  open(settings());
  submit(both_forms("06 0000 0001"));
  submit(job(kRead));
  const Instant start = now_;
  advance(1s);
  EXPECT_THAT(frames_, ElementsAre("00 06 00 00 00 01 49 DB", "81 86 00 00 00 01 56 14",
                                   "01 03 00 00 00 01 84 0A"));
  EXPECT_EQ(frame_times_[1] - start, kEmission + 100ms);
  EXPECT_EQ(frame_times_[2] - start, 2 * (kEmission + 100ms));
  EXPECT_EQ(endings_.at(0), Ending::transmitted);
  EXPECT_EQ(ended_at_[0] - start, 2 * kEmission + 100ms);  // when the last form has left
  EXPECT_EQ(bus_->counters().broadcasts, 2U);
}

TEST_F(BusBroadcast, NothingComesBetweenTheForms) {
  open(settings());
  submit(both_forms("05 000B FF00"));
  submit(job_of(1, kRead, 2));
  advance(kEmission + 100ms);
  EXPECT_THAT(frames_, ElementsAre("00 05 00 0B FF 00 FC 29", "81 85 00 0B FF 00 E3 E6"));
}

TEST_F(BusBroadcast, WritesOfSeveralRegistersHaveAFormForAutonicsToo) {
  open(settings());
  bus::Job& write = job("10 0000 0001 02 0005", 129);
  write.transactions[0].broadcast = drive::BroadcastForm{129, 0x80};
  submit(write);
  EXPECT_THAT(frames_, ElementsAre("81 90 00 00 00 01 02 00 05 0F F5"));
}

TEST_F(BusBroadcast, NoFormIsSentAfterTheDeadline) {
  open(settings());
  bus::Job& late = both_forms("06 0000 0001");
  late.deadline = now_ + 50ms;
  submit(late);
  const Instant start = now_;
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(1));
  EXPECT_THAT(endings_, ElementsAre(Ending::expired));
  EXPECT_EQ(ended_at_[0] - start, 50ms);
  EXPECT_TRUE(late.was_on_wire);
}

TEST_F(BusBroadcast, OfAStopAllFormsGoBeforeOtherStops) {
  open(settings(), {axis(settings())});
  submit(both_forms(kStop));
  submit(job_of(1, kStop));
  advance(3 * kEmission + 250ms);
  EXPECT_THAT(frames_,
              ElementsAre(StartsWith("00 06 00 7C"), StartsWith("81 86 00 7C"), kStopFrame));
}

TEST_F(BusBroadcast, ThatReachesADriveByItsSecondFormIsCancelledByTheStopOfThatDrive) {
  drive::Device aic = axis(settings());
  aic.profile.broadcast.form = drive::BroadcastForm{129, 0x80};
  open(settings(), {aic});
  submit(job_of(1, kRead, 2));
  submit(both_forms("06 0000 0001"));
  submit(job_of(2, kStop));
  EXPECT_THAT(endings_, ElementsAre(Ending::cancelled));
}

TEST_F(BusBroadcast, AStopIsNotJoinedToOneOfWhichAFormHasLeft) {
  open(settings(), {axis(settings())});
  submit(both_forms(kStop));
  advance(kEmission + 50ms);
  submit(both_forms(kStop));
  advance(1s);
  EXPECT_THAT(frames_, ElementsAre(StartsWith("00 06"), StartsWith("81 86"), StartsWith("00 06"),
                                   StartsWith("81 86")));
  EXPECT_THAT(endings_, ElementsAre(Ending::transmitted, Ending::transmitted));
}

// To the drive that hears its first form it is an ordinary write.
TEST_F(BusBroadcast, AStopInAllFormsThatIsRepeatedLetsOthersGoFirst) {
  drive::Device aic = axis(settings());
  aic.profile.broadcast.form = drive::BroadcastForm{129, 0x80};
  drive::Device other = axis(settings(), 2);
  other.profile.stops = {{.address = 0x0080, .value = 1}};
  open(settings(), {aic, other});
  submit(both_forms(kStop));
  advance(300ms);
  submit(job_of(1, "06 0080 0001", 2));
  advance(10ms);
  submit(job_of(1, kRead, 2));
  submit(both_forms(kStop));
  line(frames_.back());
  advance(5ms);
  EXPECT_EQ(frames_.back(), kOtherDevice);
}

TEST_F(BusBroadcast, OfAStopAllFormsGoThoughTheLineIsNotSilentAnyMore) {
  open(settings(), {axis(settings())});
  submit(both_forms(kStop));
  advance(kEmission);
  for (int times = 0; times < 2100; ++times) {
    line("FF");
    advance(1ms);
  }
  EXPECT_THAT(frames_, ElementsAre(StartsWith("00 06"), StartsWith("81 86")));
  EXPECT_THAT(endings_, ElementsAre(Ending::transmitted));
}

TEST_F(BusBroadcast, SaysNothingOfTheDeviceThatHasTheAddress) {
  open(settings());
  bus::Job& write = job("06 0000 0001", 129);
  write.transactions[0].broadcast = drive::BroadcastForm{129, 0x80};
  submit(write);
  advance(1s);
  EXPECT_EQ(bus_->devices()[129].counters.transmissions, 0U);
}

TEST_F(BusBroadcast, AnAnswerToABroadcastIsStray) {
  auto without_echo = settings();
  without_echo.line.echo = false;
  open(without_echo);
  submit(job("06 0000 0001", 0));
  line("00 06 00 00 00 01 49 DB");
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::transmitted));
  EXPECT_EQ(bus_->counters().unsolicited_frames, 1U);
}

TEST_F(BusBroadcast, NotEvenAStopGoesWithinTheTurnaroundOfTheBusBefore) {
  bus::Bus before(settings(), {});
  before.handle_opened(now_);
  now_ += 5ms;
  EXPECT_TRUE(before.submit(job("06 0000 0001", 0), now_));
  before.handle_looked(now_);
  const Instant over = now_ + kEmission + settings().turnaround;
  now_ += 10ms;
  bus_.emplace(settings(), std::vector<drive::Device>{});
  bus_->take_over(before, now_);
  bus_->handle_opened(now_);
  drain();
  bus::Job& stop = job("06 007C 00E1");
  stop.job_class = bus::JobClass::stop;
  submit(stop);
  advance(1s);
  EXPECT_EQ(frame_times_.at(0), over);
}

}  // namespace
}  // namespace mbgate::test
