// SPDX-License-Identifier: Apache-2.0
// A driver that still holds what should have left.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

using Fault = bus::LineFault;
constexpr auto kSilentWrite = "06 0000 0001";

class BusStalledDriver : public Bus {
 protected:
  void open_with_silent_write() {
    drive::Device device{"drive", {}, 1, settings().timing};
    device.profile.unanswered = {{{.address = 0, .mask = 0, .value = 0}, 3s}};
    open(settings(), {device});
  }
  void holds(std::size_t bytes) { bus_->note_unsent(bytes); }
  [[nodiscard]] bool is_lost() const { return closes_ == 1 && !bus_->link().is_open(); }
};

TEST_F(BusStalledDriver, IsLostAtAResponseTimeout) {
  open(settings());
  bus::Job& write = job(kSilentWrite);
  submit(write);
  submit(job(kRead, 2));
  holds(8);
  advance(kEmission + 99ms);
  EXPECT_THAT(endings_, IsEmpty());
  advance(1ms);
  EXPECT_TRUE(is_lost());
  EXPECT_THAT(faults_, ElementsAre(Fault::driver_stalled));
  EXPECT_THAT(endings_, ElementsAre(Ending::closed, Ending::closed));
  EXPECT_TRUE(write.was_on_wire);
  EXPECT_THAT(frames_, SizeIs(1));
  EXPECT_EQ(bus_->counters().losses, 1U);
  EXPECT_EQ(bus_->counters().timeouts, 0U);  // nobody knows whether the device was asked
}

TEST_F(BusStalledDriver, IsNotOneThatHoldsNothing) {
  open(settings());
  submit(job(kSilentWrite));
  holds(8);
  advance(kEmission);
  holds(0);
  advance(100ms);
  EXPECT_EQ(closes_, 0U);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

TEST_F(BusStalledDriver, IsNotOneWhoseDeviceAnswers) {
  open(settings());
  submit(job(kRead));
  holds(2);
  advance(kEmission + 99ms);
  line("01 03 02");
  advance(2ms);
  line("12 34 B5 33");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  advance(1s);
  EXPECT_EQ(closes_, 0U);
}

TEST_F(BusStalledDriver, IsLostBeforeWhatFollowsABroadcast) {
  open(settings());
  submit(job(kSilentWrite, 0));
  holds(8);
  advance(1s);
  EXPECT_EQ(closes_, 0U);
  EXPECT_THAT(endings_, ElementsAre(Ending::transmitted));
  submit(job(kRead));
  EXPECT_TRUE(is_lost());
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(BusStalledDriver, IsLostBeforeWhatWaitsForTheTurnaroundOfABroadcast) {
  open(settings());
  submit(job(kSilentWrite, 0));
  submit(job(kRead));
  holds(8);
  advance(1s);
  EXPECT_TRUE(is_lost());
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(BusStalledDriver, MayBeALittleLateWithABroadcast) {
  auto quick = settings();
  quick.turnaround = 0ms;
  open(quick);
  submit(job(kSilentWrite, 0));
  submit(job(kRead));
  holds(1);
  advance(kEmission + 5ms);
  EXPECT_EQ(closes_, 0U);
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusStalledDriver, IsLostWithAWriteThatNothingAnswers) {
  open_with_silent_write();
  submit(job(kSilentWrite));
  holds(8);
  advance(1s);
  EXPECT_TRUE(is_lost());
  EXPECT_THAT(endings_, ElementsAre(Ending::closed));
}

TEST_F(BusStalledDriver, ThatHoldsNothingWhenThePortIsOpenIsWell) {
  open(settings());
  submit(job(kSilentWrite));
  holds(8);
  advance(300ms);
  bus_->handle_opened(now_);
  drain();
  advance(5ms);
  submit(job(kRead));
  time_out();
  EXPECT_EQ(closes_, 1U);
  EXPECT_EQ(endings_.back(), Ending::no_answer);
}

}  // namespace
}  // namespace mbgate::test
