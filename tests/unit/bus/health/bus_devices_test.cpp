// SPDX-License-Identifier: Apache-2.0
// What a bus knows of its devices: slow registers, writes that are never answered, settings
// of their own.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

using modbus::Table;

constexpr auto kRestart = "06 00D4 0100";
constexpr auto kRestartFrame = "01 06 00 D4 01 00 C8 62";
constexpr auto kSave = "06 00DC 0001";

bus::BusSettings quick_turnaround(bus::BusSettings settings) {
  settings.turnaround = 40ms;
  settings.settle = 500ms;
  return settings;
}

// The restart of the RS-485 stepper, which boots for 3 s, and its save, which takes 1 s.
drive::Device stepper(const bus::BusSettings& settings, std::uint8_t address = 1) {
  drive::Device device{"stepper", {}, address, settings.timing};
  device.profile.unanswered = {{{Table::holding_registers, 0x00D4, 0xFF00, 0, true}, 3s}};
  device.profile.slow = {{{Table::holding_registers, 0x00DC, 1}, 1s}};
  return device;
}

TEST_F(Bus, WritesAndReadsOfSlowRegistersHaveALongerTimeout) {
  for (const auto* request :
       {kSave, "03 00DC 0001", "03 00D0 0010", "17 00DC 0001 0000 0001 02 0000"}) {
    endings_.clear();
    ended_at_.clear();
    open(settings(), {stepper(settings())});
    submit(job(request));
    const Instant start = now_;
    advance(10s);
    ASSERT_THAT(endings_, ElementsAre(Ending::no_answer)) << request;
    EXPECT_GE(ended_at_[0] - start, 1s) << request;
  }
}

TEST_F(Bus, ReadsBesideSlowRegistersHaveTheUsualTimeout) {
  open(settings(), {stepper(settings())});
  submit(job("03 00DD 0001"));
  const Instant start = now_;
  advance(2s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(ended_at_[0] - start, kEmission + 100ms);
}

TEST_F(Bus, AWriteThatIsNeverAnsweredIsDoneAfterTheTurnaroundDelay) {
  const auto quick = quick_turnaround(settings());
  open(quick, {stepper(quick)});
  submit(job(kRestart));
  const Instant start = now_;
  advance(1s);
  EXPECT_THAT(frames_, ElementsAre(kRestartFrame));
  EXPECT_THAT(endings_, ElementsAre(Ending::transmitted));
  EXPECT_EQ(ended_at_[0] - start, kEmission + 40ms);
  EXPECT_EQ(bus_->counters().timeouts, 0U);
  EXPECT_EQ(bus_->devices()[1].counters.timeouts, 0U);
  EXPECT_EQ(bus_->devices()[1].health.unanswered_in_row(), 0U);
}

TEST_F(Bus, ABootingDeviceIsHeldBackWhileOthersGoOn) {
  const auto quick = quick_turnaround(settings());
  open(quick, {stepper(quick)});
  submit(job(kRestart));
  submit(job(kRead, 1));
  submit(job(kRead, 2));
  const Instant silence = now_ + kEmission + 40ms;
  advance(kEmission + 40ms);
  EXPECT_THAT(frames_, ElementsAre(kRestartFrame, "02 03 00 00 00 01 84 39"));
  advance(5ms);
  line("02 03 02 12 34 F1 33");
  EXPECT_EQ(next_deadline(), silence + 3s);
  advance(5s);
  ASSERT_THAT(frames_, SizeIs(3));
  EXPECT_EQ(frames_[2], "01 03 00 00 00 01 84 0A");
  EXPECT_EQ(frame_times_[2], silence + 3s);
}

TEST_F(Bus, AWaitForABootingDeviceEndsAtTheDeadline) {
  open(settings(), {stepper(settings())});
  submit(job(kRestart));
  bus::Job& waiting = job(kRead);
  waiting.deadline = now_ + 1s;
  submit(waiting);
  const Instant start = now_;
  advance(5s);
  EXPECT_THAT(endings_, ElementsAre(Ending::transmitted, Ending::expired));
  EXPECT_EQ(ended_at_[1] - start, 1s);
  EXPECT_THAT(frames_, SizeIs(1));
}

TEST_F(Bus, AnExceptionToAWriteThatIsNeverAnsweredIsTaken) {
  open(settings(), {stepper(settings())});
  bus::Job& restart = job(kRestart);
  submit(restart);
  submit(job(kRead));
  advance(10ms);
  line("01 86 04 43 A3");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(hex(restart.transactions[0].response->bytes()), "86 04");
  EXPECT_EQ(until_next_frame(), kT35);
}

TEST_F(Bus, ADeviceThatAnswersBeforeItBootsIsHeldBackToo) {
  open(settings(), {stepper(settings())});
  submit(job(kRestart));
  submit(job(kRead));
  advance(10ms);
  line(kRestartFrame);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(until_next_frame(5s), 3s);
}

TEST_F(Bus, OtherWritesOfTheSameRegisterAreAnsweredAsUsual) {
  open(settings(), {stepper(settings())});
  submit(job("06 00D4 0001"));
  submit(job(kRestart, 2));  // this address has no such device
  advance(1s);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
  EXPECT_EQ(bus_->counters().timeouts, 2U);
}

TEST_F(Bus, AJobGoesOnAfterAWriteThatIsNotAnsweredAndOnlyOtherDevicesPassIt) {
  const auto quick = quick_turnaround(settings());
  open(quick, {stepper(quick)});
  bus::Job& run = job(kRestart);
  add(run, "06 0000 0001");
  submit(run);
  bus::Job& other = job_of(1, kRead, 2);
  submit(other);
  bus::Job& same = job_of(2, kRead);
  submit(same);
  const Instant start = now_;
  advance(6s);
  EXPECT_THAT(frames_, ElementsAre("01 06 00 D4 01 00 C8 62", "02 03 00 00 00 01 84 39",
                                   "01 06 00 00 00 01 48 0A", "01 03 00 00 00 01 84 0A"));
  EXPECT_EQ(frame_times_[2] - start, kEmission + 40ms + 3s);
}

const std::vector<std::uint16_t> kSetting{0x1234};

class BusSettings : public Bus {
 protected:
  /// Its word order is stated, and register 0 holds 1234 if it has that.
  static drive::Device stated() {
    auto device = stepper(settings());
    device.word_order = drive::WordOrder::big;
    device.profile.word_order_register = drive::WordOrderRegister{0, kSetting, {}};
    return device;
  }
  /// A write with a question before it: register 0 must hold 1234.
  bus::Job& asking() {
    bus::Job& write = job(kRead);
    write.transactions.front().must_hold = &kSetting;
    add(write, "06 0001 0001");
    return write;
  }
  void answer_write() {
    advance(30ms);
    line("01 06 00 01 00 01 19 CA");
    advance(30ms);
  }
  /// Is the question put again? The device then answers it.
  bool is_asked() {
    frames_.clear();
    submit(asking());
    const bool asked = frames_.size() == 1 && frames_[0].substr(0, 5) == "01 03";
    if (asked) {
      line(kAnswer);
    }
    answer_write();
    return asked;
  }
};

TEST_F(BusSettings, AreAskedForOnceAndAgainAfterSilenceOrAnotherLine) {
  open(settings(), {stated()});
  EXPECT_TRUE(is_asked());
  EXPECT_FALSE(is_asked());
  submit(job("06 0001 0001"));
  advance(11s);
  EXPECT_TRUE(is_asked());
  EXPECT_FALSE(is_asked());
  bus_->handle_lost(now_);
  bus_->handle_opened(now_);
  drain();
  advance(30ms);
  EXPECT_TRUE(is_asked());
}

TEST_F(BusSettings, AreAskedForAgainWhenABroadcastMayHaveChangedThem) {
  auto told = stated();
  told.profile.broadcast.form = drive::BroadcastForm{};
  told.profile.communication = {{modbus::Table::holding_registers, 0, 1}};
  open(settings(), {told});
  EXPECT_TRUE(is_asked());
  EXPECT_FALSE(is_asked());
  submit(job("06 0000 0001", 0));
  advance(1s);
  EXPECT_TRUE(is_asked());
}

TEST_F(BusSettings, AnUnansweredWriteBehindItsQuestionMakesItUncertain) {
  open(settings(), {stated()});
  submit(asking());
  line(kAnswer);
  advance(1s);  // the write itself is not answered
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_TRUE(is_asked());
}

TEST_F(BusSettings, AWriteThatWaitsBehindAChangeOfTheSettingAsksAgain) {
  auto device = stated();
  device.profile.communication = {{modbus::Table::holding_registers, 1, 1}};
  open(settings(), {device});
  EXPECT_TRUE(is_asked());
  submit(job("06 0001 0001"));
  frames_.clear();
  submit(asking());
  answer_write();
  ASSERT_THAT(frames_, SizeIs(1));
  EXPECT_EQ(frames_[0].substr(0, 5), "01 03");
}

// The device owes the answer to a write. A question may be put meanwhile, but where the answer is
// known already the write comes next.
TEST_F(BusSettings, AWriteWhoseQuestionIsNotPutWaitsForTheQuarantine) {
  auto device = stated();
  device.profile.stops = {{.address = 7, .mask = 0, .value = 0}};
  open(settings(), {device});
  submit(job("06 0002 0001"));
  time_out();
  submit(job("10 0007 0001 02 0001"));
  line("01 10 00 07 00 01 B0 08");
  advance(30ms);
  bus::Job& given_up = asking();
  given_up.deadline = now_ + 10ms;
  submit(given_up);
  line(kAnswer);
  advance(10ms);
  ASSERT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered, Ending::expired));
  submit(asking());
  EXPECT_THAT(frames_, SizeIs(3));
  advance(400ms);
  ASSERT_THAT(frames_, SizeIs(4));
  EXPECT_EQ(frames_[3].substr(0, 5), "01 06");
}

// Settings that came while the question was on the wire have the answer elsewhere.
TEST_F(BusSettings, WhatOneRegisterHeldIsNotShownOfAnother) {
  open(settings(), {stated()});
  submit(asking());
  auto elsewhere = stated();
  elsewhere.profile.word_order_register->address = 9;
  update(settings(), {elsewhere});
  line(kAnswer);
  EXPECT_EQ(bus_->devices()[1].setting, std::nullopt);
  answer_write();
  auto other = stated();
  other.word_order = drive::WordOrder::little;
  update(settings(), {stated()});
  submit(asking());
  update(settings(), {other});
  line(kAnswer);
  EXPECT_EQ(bus_->devices()[1].setting, std::nullopt);
  answer_write();
  update(settings(), {stated()});
  EXPECT_TRUE(is_asked());
  EXPECT_EQ(bus_->devices()[1].setting, 0x1234);
}

TEST_F(BusSettings, AnotherAnswerEndsTheJobBeforeItsWrite) {
  open(settings(), {stated()});
  bus::Job& write = asking();
  submit(write);
  line("01 03 02 00 05 78 47");
  EXPECT_THAT(endings_, ElementsAre(Ending::mismatched));
  EXPECT_FALSE(write.was_on_wire);
  advance(1s);
  EXPECT_THAT(frames_, SizeIs(1));
}

}  // namespace
}  // namespace mbgate::test
