// SPDX-License-Identifier: Apache-2.0
// A Modbus TCP server with faults: lengths that are wrong, answers that stop half-way, and a server
// that did not reach the device.
#include "bus_tcp_rig.hpp"

namespace mbgate::test {
namespace {

using bus::DeviceState;
using Kind = bus::DeviceNotice::Kind;

TEST_F(BusTcp, AnExceptionHasTwoBytesWhateverItsLengthSays) {
  for (const std::string_view length : {"00 00", "00 02", "00 04", "00 47", "00 FE", "01 2C"}) {
    frames_.clear();
    endings_.clear();
    open(tcp());
    bus::Job& refused = job(kRead);
    submit(refused);
    submit(job(kRead));
    line(frames_[0].substr(0, 5) + " 00 00" + std::string(length) + "01 83 02");
    ASSERT_THAT(endings_, ElementsAre(Ending::answered)) << length;
    EXPECT_EQ(hex(refused.transactions[0].response->bytes()), "83 02");
    answer(1, "01 03 02 12 34");
    EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered)) << length;
    EXPECT_EQ(closes_, 0U);
  }
}

// The drive is there, and nothing shows that it is not: another number of registers, another value.
TEST_F(BusTcp, AnAnswerThatDoesNotFitEndsTheWait) {
  auto once = tcp();
  once.timing.offline_after = 1;
  open(once);
  submit(job("03 0000 0002"));
  answer(0, "01 03 02 12 34");
  submit(job("06 0005 2710"));
  answer(1, "01 06 00 05 03 E8");
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
  EXPECT_EQ(bus_->devices()[1].health.state(), DeviceState::answering);
  EXPECT_THAT(notices_, ElementsAre(Kind::misfit));
  submit(job(kRead));
  answer(2, "01 04 02 12 34");  // of another function: it may be the answer to somebody else
  answer(2, "01 03 02 12 34");
  EXPECT_EQ(endings_.back(), Ending::answered);
}

TEST_F(BusTcp, AnAnswerThatDoesNotFitIsAskedForOnceMore) {
  auto retrying = tcp();
  retrying.timing.retries = 1;
  open(retrying);
  bus::Job& read = job(kRead);
  submit(read);
  answer(0, "01 03 04 12 34 56 78");
  ASSERT_THAT(frames_, SizeIs(2));
  answer(0, "01 03 02 12 34");  // the first is over
  EXPECT_THAT(endings_, IsEmpty());
  answer(1, "01 03 02 56 78");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(hex(read.transactions[0].response->bytes()), "03 02 56 78");
}

TEST_F(BusTcp, ALimitedValueIsAnAnswerWhereTheDeviceMaySaySo) {
  drive::Device axis{"axis", {}, 1, tcp().timing};
  axis.limits_values = true;
  open(tcp(), {axis});
  submit(job("06 0005 2710"));
  answer(0, "01 06 00 05 03 E8");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusTcp, AnExceptionThatIsSentByteByByteIsTakenWithItsLast) {
  open(tcp());
  submit(job(kRead));
  for (const std::string_view byte : {"00", "01", "00", "00", "00", "04", "01", "83"}) {
    line(byte);
    EXPECT_THAT(endings_, IsEmpty());
  }
  line("02");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

// It may have the first byte of the next identifier; and it comes with the exception, alone, or
// before the next answer.
TEST_F(BusTcp, TheBytesThatItsLengthPromisesAreNoAnswer) {
  for (const std::string_view padding : {"AA", "00"}) {
    for (const int place : {0, 1, 2}) {
      frames_.clear();
      endings_.clear();
      open(tcp());
      submit(job(kRead));
      const auto part = [&](int now) { return std::string(now == place ? padding : ""); };
      line("00 01 00 00 00 04 01 83 02" + part(0));
      line(part(1));
      bus::Job& next = job(kRead);
      submit(next);
      line(part(2) + "00 02 00 00 00 05 01 03 02 12 34");
      EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered)) << padding << place;
      EXPECT_EQ(bus_->counters().stray_bytes, 1U);
    }
  }
}

TEST_F(BusTcp, WhatIsPromisedBehindAnExceptionIsNoPartOfAnAnswer) {
  open(tcp());
  submit(job(kRead));
  line("00 01 00 00 00 04 01 83 02 00");
  submit(job(kRead));
  advance(100ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer));
  EXPECT_THAT(faults_, IsEmpty());
}

TEST_F(BusTcp, ATimeoutBehindHalfAnAnswerReplacesTheConnection) {
  auto retrying = tcp();
  retrying.timing.retries = 1;
  open(retrying);
  submit(job(kRead));
  submit(job(kRead));
  line("00 01 00 00 00 47 01 03 02 12 34");  // 71 instead of 5
  advance(99ms);
  EXPECT_THAT(replaced_, IsEmpty());
  advance(1ms);
  EXPECT_THAT(replaced_, SizeIs(1));
  EXPECT_THAT(faults_, ElementsAre(bus::LineFault::answer_cut_off));
  EXPECT_EQ(opens_, 2U);  // at once
  EXPECT_THAT(endings_, IsEmpty());
  EXPECT_EQ(bus_->counters().losses, 1U);
  reopen();
  ASSERT_THAT(frames_, SizeIs(2));
  answer(1, "01 03 02 12 34");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  answer(2, "01 03 02 12 34");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

TEST_F(BusTcp, NothingIsSentBehindAPartOfAnAnswerThatNobodyAwaits) {
  open(tcp());
  submit(job(kRead));
  line("00 01 00 00 00 05 01 03 02 12 34 00 01 00 00 00 05 01 03 02");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  submit(job(kRead));
  advance(199ms);
  EXPECT_THAT(replaced_, IsEmpty());
  advance(1ms);
  EXPECT_THAT(frames_, SizeIs(1));
  EXPECT_THAT(faults_, ElementsAre(bus::LineFault::answer_cut_off));
  reopen();
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusTcp, WhatWaitsBehindAPartGoesWhenItsRestHasCome) {
  open(tcp());
  submit(job(kRead));
  line("00 01 00 00 00 05 01 03 02 12 34 00 01 00 00 00 05 01 03 02");
  submit(job(kRead));
  advance(50ms);
  EXPECT_THAT(frames_, SizeIs(1));
  line("12 34");
  EXPECT_THAT(frames_, SizeIs(2));
  EXPECT_THAT(faults_, IsEmpty());
}

TEST_F(BusTcp, HalfAnAnswerThatIsStillWaitedForMayGoOn) {
  drive::Device slow{"slow", {}, 2, settings().timing};
  slow.timing.response_timeout = 1s;
  open(tcp(2), {slow});
  submit(job(kRead, 1));
  submit(job(kRead, 2));
  line("00 02 00 00 00 05 02");
  advance(100ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_THAT(faults_, IsEmpty());
  line("03 02 12 34");
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
}

TEST_F(BusTcp, AWriteThatLostFramingCutsIsNotRepeated) {
  open(tcp(2));
  submit(job(kRead, 1));
  advance(50ms);
  submit(job("06 0000 0001", 2));
  line("00 01 00 00 00 47 01 03 02 12 34");
  advance(50ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::no_answer));
  EXPECT_THAT(frames_, SizeIs(2));
}

class BusTcpGateway : public BusTcp {
 protected:
  void open_gateway() {
    auto behind = tcp();
    behind.timing.offline_after = 3;
    open(behind);
  }
  void ask(std::string_view response, std::string_view request = kRead) {
    submit(job(request));
    answer(frames_.size() - 1, response);
    advance(1ms);
  }
  [[nodiscard]] const bus::DeviceEntry& device() const { return bus_->devices()[1]; }
};

TEST_F(BusTcpGateway, SaysThatItDidNotReachTheDevice) {
  for (const std::string_view unreached : {"01 83 0A", "01 83 0B"}) {
    endings_.clear();
    notices_.clear();
    frames_.clear();
    open_gateway();
    ask("01 03 02 12 34");
    EXPECT_EQ(device().health.state(), DeviceState::answering);
    ask(unreached);
    EXPECT_EQ(device().health.state(), DeviceState::not_answering);
    EXPECT_EQ(device().silence.transmissions(), 1U);
    EXPECT_EQ(device().unreached, unhex(unreached).back());
    ask(unreached);
    ask(unreached);
    EXPECT_THAT(endings_, testing::Each(Ending::answered));  // the client gets the exception
    EXPECT_EQ(device().health.state(), DeviceState::offline);
    EXPECT_THAT(notices_, ElementsAre(Kind::lost));
    EXPECT_EQ(device().counters.exceptions, 3U);
    EXPECT_EQ(device().counters.timeouts, 0U);
  }
}

TEST_F(BusTcpGateway, TakesItsAnswersOfBeforeForNoneOfNow) {
  const auto cached = tcp();
  drive::Device axis{"axis", {}, 1, cached.timing};
  axis.cache = 1s;
  open(cached, {axis});
  ask("01 03 02 12 34");
  ask("01 86 0B", "06 0000 0001");
  submit(job(kRead));
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

TEST_F(BusTcpGateway, OtherExceptionsAreTheDevicesAnswers) {
  open_gateway();
  for (const std::string_view refusal : {"01 83 02", "01 83 04", "01 83 06", "01 83 10"}) {
    ask(refusal);
    EXPECT_EQ(device().health.state(), DeviceState::answering);
  }
}

TEST_F(BusTcpGateway, BringsNoDeviceBackByThat) {
  open_gateway();
  for (int times = 0; times < 3; ++times) {
    ask("01 83 0B");
  }
  advance(2s);
  ask("01 83 0B");  // the probe
  EXPECT_EQ(device().health.state(), DeviceState::offline);
  EXPECT_THAT(notices_, ElementsAre(Kind::lost));
  advance(2s);
  ask("01 03 02 12 34");
  EXPECT_THAT(notices_, ElementsAre(Kind::lost, Kind::back));
}

TEST_F(BusTcpGateway, HoldsNothingByThat) {
  open_gateway();
  ask("01 86 0B", "06 0000 0001");
  submit(job("06 0000 0002"));
  EXPECT_THAT(frames_, SizeIs(2));
}

TEST_F(BusTcpGateway, SayingSoLateIsNoAnswerEither) {
  open_gateway();
  submit(job(kRead));
  advance(100ms);
  answer(0, "01 83 0B");
  EXPECT_EQ(device().health.state(), DeviceState::not_answering);
  EXPECT_EQ(device().health.unanswered_in_row(), 1U);
}

TEST_F(BusTcpGateway, OnASerialLineThatIsAnAnswer) {
  auto serial = settings();
  serial.timing.offline_after = 3;
  open(serial);
  submit(job(kRead));
  advance(10ms);
  const auto frame = modbus::encode_rtu(1, *modbus::Pdu::from(unhex("83 0B")));
  line(hex({frame.data(), frame.size()}));
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(device().health.state(), DeviceState::answering);
}

}  // namespace
}  // namespace mbgate::test
