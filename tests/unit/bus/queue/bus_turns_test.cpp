// SPDX-License-Identifier: Apache-2.0
// Whose turn it is: clients one after the other, devices that are held back, gaps, broadcasts.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

constexpr auto kBoot = "06 0001 0001";

class BusTurns : public Bus {
 protected:
  /// Device 1 boots for 3 s after kBoot; device 5 wants a gap of 30 ms.
  void open_with_devices() {
    drive::Device booting{"booting", {}, 1, settings().timing};
    booting.profile.unanswered = {{{.address = 1, .mask = 0, .value = 0}, 3s}};
    drive::Device gapped{"gapped", {}, 5, settings().timing};
    gapped.timing.gap = 30ms;
    open(settings(), {booting, gapped});
  }
  /// Afterwards device 1 is held back until `held_until_`.
  void boot(const char* write = kBoot) {
    submit(job(write));
    time_out();
    held_until_ = now_ + 3s;
    frames_.clear();
    frame_times_.clear();
  }
  /// Keeps the line busy until refuse(9), so that what is submitted meanwhile waits.
  void occupy() {
    submit(job_of(9, kRead, 9));
    advance(10ms);
  }
  /// The devices that requests go to within `limit`; each answers after 10 ms.
  std::vector<int> served(Duration limit) {
    return Bus::served(limit, [this] {
      advance(9ms);
      const std::uint8_t address = unhex(frames_.back())[0];
      refuse(address);
      return address;
    });
  }
  Instant held_until_;
};

TEST_F(BusTurns, ADeviceBootsThoughTheLineIsLostMeanwhile) {
  open_with_devices();
  submit(job(kBoot));
  advance(10ms);
  const Instant lost = now_;
  bus_->handle_lost(now_);
  advance(1s);
  bus_->handle_opened(now_);
  submit(job_of(1, kRead, 1));
  frame_times_.clear();
  advance(5s);
  EXPECT_THAT(frame_times_, ElementsAre(lost + 3s));
}

TEST_F(BusTurns, ClientsTakeTurns) {
  open_with_devices();
  occupy();
  for (int times = 0; times < 3; ++times) {
    submit(job_of(0, kRead, 2));
  }
  submit(job_of(1, kRead, 3));
  submit(job_of(1, kRead, 3));
  refuse(9);
  EXPECT_THAT(served(100ms), ElementsAre(2, 3, 2, 3, 2));
}

TEST_F(BusTurns, ClientsTakeTurnsThoughADeviceIsHeldBack) {
  open_with_devices();
  boot();
  occupy();
  for (const std::uint8_t address : std::initializer_list<std::uint8_t>{1, 2, 1, 4}) {
    submit(job_of(0, kRead, address));
  }
  for (const std::uint8_t address : std::initializer_list<std::uint8_t>{3, 1, 3}) {
    submit(job_of(1, kRead, address));
  }
  refuse(9);
  EXPECT_THAT(served(1s), ElementsAre(2, 3, 4, 3));
  const std::size_t before = frames_.size();
  EXPECT_THAT(served(3s), ElementsAre(1, 1, 1));
  EXPECT_EQ(frame_times_[before], held_until_);
}

TEST_F(BusTurns, ADeviceBootsToldAmongOtherRegistersToo) {
  open_with_devices();
  boot("10 0000 0002 04 0000 0001");
  submit(job(kRead, 1));
  served(4s);
  ASSERT_THAT(frames_, SizeIs(1));
  EXPECT_GE(frame_times_[0], held_until_);
}

// It may have carried out what it was told.
TEST_F(BusTurns, ADeviceIsHeldBackTooWhereABadCrcCameInsteadOfNothing) {
  open_with_devices();
  submit(job(kBoot));
  line("01 06 00 01 00 11 D9 C5");
  advance(20ms);
  held_until_ = now_ + 3s;
  submit(job(kRead, 1));
  served(4s);
  ASSERT_THAT(frames_, SizeIs(2));
  EXPECT_NEAR(static_cast<double>((held_until_ - frame_times_[1]) / 1ms), 0, 25);
}

TEST_F(BusTurns, AClientsRequestsToAHeldDeviceKeepTheirOrder) {
  open_with_devices();
  boot();
  submit(job("06 0010 0001"));
  submit(job("03 0010 0001"));
  submit(job("06 0010 0002"));
  EXPECT_EQ(next_deadline(), held_until_);
  served(4s);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[0], "01 06 00 10 00 01 49 CF");
  EXPECT_EQ(frames_[1], "01 03 00 10 00 01 85 CF");
  EXPECT_EQ(frames_[2], "01 06 00 10 00 02 09 CE");
  EXPECT_EQ(frame_times_[0], held_until_);
}

TEST_F(BusTurns, ABroadcastOvertakesNothingOfItsClientAndNothingOvertakesIt) {
  open_with_devices();
  boot();
  submit(job_of(0, kRead, 1));
  submit(job_of(0, "06 0000 0001", 0));
  submit(job_of(0, kRead, 2));
  advance(100ms);
  EXPECT_THAT(frames_, IsEmpty());
  submit(job_of(1, "06 0000 0001", 0));
  EXPECT_THAT(frames_, ElementsAre("00 06 00 00 00 01 49 DB"));
  advance(1s);
  frames_.clear();
  served(4s);
  EXPECT_THAT(frames_, ElementsAre("01 03 00 00 00 01 84 0A", "00 06 00 00 00 01 49 DB",
                                   "02 03 00 00 00 01 84 39"));
}

TEST_F(BusTurns, WhatWaitsBehindAJobThatIsTakenBackGoesAtOnce) {
  open_with_devices();
  boot();
  bus::Job& held = job(kRead, 1);
  submit(held);
  submit(job("06 0000 0001", 0));
  advance(100ms);
  EXPECT_THAT(frames_, IsEmpty());
  bus_->withdraw(held);
  ASSERT_LE(next_deadline(), now_);
  bus_->handle_deadline(now_);
  drain();
  EXPECT_THAT(frames_, ElementsAre("00 06 00 00 00 01 49 DB"));
}

TEST_F(BusTurns, WhatWaitsForItsDeviceDoesNotWaitForTheLine) {
  open(settings());
  submit(job_of(1, kRead));
  time_out();  // it owes an answer
  submit(job_of(1, "06 0000 0001"));
  submit(job_of(2, kRead, 2));  // occupies the line
  submit(job_of(2, kRead, 3));
  const auto most = bus_->parts().most_waiting(now_);
  ASSERT_TRUE(most);
  EXPECT_EQ(most->source, bus::FairnessKey{2});
  EXPECT_EQ(most->of, 1U);
}

TEST_F(BusTurns, AGapIsWaitedForInTurn) {
  open_with_devices();
  submit(job_of(0, kRead, 2));
  submit(job_of(0, kRead, 5));
  submit(job_of(0, kRead, 3));
  advance(20ms);
  refuse(2);
  EXPECT_EQ(until_next_frame(kT35 + 30ms), kT35 + 30ms);
  EXPECT_EQ(frames_.back(), "05 03 00 00 00 01 85 8E");
  advance(20ms);
  refuse(5);
  EXPECT_EQ(until_next_frame(kT35), kT35);
  EXPECT_EQ(frames_.back(), "03 03 00 00 00 01 85 E8");
}

TEST_F(BusTurns, OnABusyLineAGapTakesNobodysTurn) {
  open_with_devices();
  occupy();
  for (int round = 0; round < 3; ++round) {
    submit(job_of(0, kRead, 5));
    submit(job_of(1, kRead, 2));
    submit(job_of(2, kRead, 3));
  }
  refuse(9);
  EXPECT_THAT(served(500ms), ElementsAre(5, 2, 3, 5, 2, 3, 5, 2, 3));
}

TEST_F(BusTurns, ABootingDeviceWithAGapDoesNotHoldTheLine) {
  drive::Device both{"both", {}, 1, settings().timing};
  both.profile.unanswered = {{{.address = 1, .mask = 0, .value = 0}, 3s}};
  both.timing.gap = 30ms;
  open(settings(), {both});
  advance(100ms);
  boot();
  submit(job_of(0, kRead, 1));
  submit(job_of(1, "04 0000 0001", 2));
  for (int times = 0; times < 4; ++times) {
    submit(job_of(1, kRead, 2));
  }
  // One went when it was submitted; after its timeout its device is left alone for as long again.
  EXPECT_THAT(served(800ms), SizeIs(4));
}

}  // namespace
}  // namespace mbgate::test
