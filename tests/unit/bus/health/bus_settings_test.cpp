// SPDX-License-Identifier: Apache-2.0
// What a device is set to, which is asked before values are written to it.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

const std::vector<std::uint16_t> kSetting{0x1234};

class BusSettings : public Bus {
 protected:
  /// Its word order is stated, and register 0 holds 1234 if it has that.
  static drive::Device stated() {
    drive::Device device{"stepper", {}, 1, settings().timing};
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

// Whether it is right, only an answer would show.
TEST_F(BusSettings, AServerThatDoesNotReachItsDeviceSaysNothingOfThem) {
  open(settings(), {stated()});
  bus::Job& write = asking();
  submit(write);
  line("01 83 0B 00 F7");
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_FALSE(write.was_on_wire);
}

TEST_F(BusSettings, ADeviceThatIsOfflineIsNotAskedBeforeABroadcast) {
  auto device = stated();
  device.timing.offline_after = 1;
  open(settings(), {device});
  submit(job(kRead));
  time_out();
  ASSERT_TRUE(bus_->devices()[1].health.is_offline());
  frames_.clear();
  bus::Job& broadcast = job(kRead);
  broadcast.transactions.front().must_hold = &kSetting;
  add(broadcast, "06 0001 0001", 0);
  submit(broadcast);
  advance(10ms);
  EXPECT_THAT(frames_, ElementsAre("00 06 00 01 00 01 18 1B"));
}

}  // namespace
}  // namespace mbgate::test
