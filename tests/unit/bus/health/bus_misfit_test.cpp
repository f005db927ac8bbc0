// SPDX-License-Identifier: Apache-2.0
// Good frames of the device that was asked, which do not fit what it was asked.
#include "unit/bus/bus_rig.hpp"

namespace mbgate::test {
namespace {

using Kind = bus::DeviceNotice::Kind;

constexpr auto kSetPoint = "06 0005 2710";
constexpr auto kLimited = "01 06 00 05 03 E8 99 75";
constexpr auto kAnswered = "01 06 00 05 27 10 83 F7";

class BusMisfit : public Bus {
 protected:
  /// It echoes a written value as it has limited it.
  static drive::Device limiting_axis() {
    drive::Device axis{"axis", {}, 1, settings().timing};
    axis.limits_values = true;
    return axis;
  }
  void ask(std::string_view request) {
    submit(job(request));
    advance(10ms);
  }
  void expect_misfit(Duration after) {
    EXPECT_THAT(endings_, IsEmpty());
    advance(after - 1ms);
    EXPECT_THAT(endings_, IsEmpty());
    advance(1ms);
    EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
    EXPECT_EQ(bus_->devices()[1].health.state(), bus::DeviceState::answering);
    EXPECT_THAT(notices_, ElementsAre(Kind::misfit));
  }
};

TEST_F(BusMisfit, ALimitedSetPointEndsTheWaitAndTheDeviceIsThere) {
  open(settings());
  ask(kSetPoint);
  line(kLimited);
  expect_misfit(20ms);
}

TEST_F(BusMisfit, ThreeOfThemTakeNoDeviceOffline) {
  auto breaking = settings();
  breaking.timing.offline_after = 3;
  open(breaking);
  for (int times = 0; times < 5; ++times) {
    ask(kSetPoint);
    line(kLimited);
    advance(200ms);
  }
  EXPECT_FALSE(bus_->devices()[1].health.is_offline());
  EXPECT_THAT(notices_, ElementsAre(Kind::misfit));
}

TEST_F(BusMisfit, IsToldAgainAfterTheSettingsHaveChanged) {
  open(settings());
  for (int times = 0; times < 2; ++times) {
    ask(kSetPoint);
    line(kLimited);
    advance(200ms);
    update(settings(), {});
  }
  EXPECT_THAT(notices_, ElementsAre(Kind::misfit, Kind::misfit));
}

TEST_F(BusMisfit, AnExceptionWithAByteMoreIsOne) {
  open(settings());
  ask(kRead);
  line("01 83 02 00 F1 50");
  expect_misfit(20ms);
}

TEST_F(BusMisfit, AnotherNumberOfRegistersIsOne) {
  open(settings());
  ask(kRead);
  line("01 03 04 12 34 56 78 81 07");
  expect_misfit(20ms);
}

TEST_F(BusMisfit, AnotherFunctionIsNone) {
  open(settings());
  ask("04 0000 0001");
  line(kAnswer);
  line("01 04 02 12 34 B4 47");
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_THAT(notices_, IsEmpty());
}

TEST_F(BusMisfit, ItsAnswerMayStandBehindIt) {
  open(settings());
  ask(kSetPoint);
  line(std::string(kLimited) + kAnswered);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusMisfit, AReadIsRepeatedOnceItsAnswerHadTime) {
  open_retrying();
  ask(kRead);
  line(kAnswer);
  ask(kRead);
  line("01 03 04 12 34 56 78 81 07");
  advance(20ms);
  EXPECT_THAT(frames_, SizeIs(2));
  advance(10ms);
  EXPECT_THAT(frames_, SizeIs(3));
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::answered));
}

TEST_F(BusMisfit, ALimitedEchoIsTheAnswerWhereTheDeviceIsToldToGiveIt) {
  open(settings(), {limiting_axis()});
  ask(kSetPoint);
  line(kLimited);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(jobs_[0].transactions[0].response, modbus::Pdu::from(unhex("06 0005 03E8")));
  EXPECT_EQ(bus_->devices()[1].counters.noise_bytes, 0U);
  ask(kSetPoint);
  line("01 06 00 06 03 E8 69 75");  // of another register
  advance(20ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered, Ending::no_answer));
}

// The same 06 with another value is still unanswered: what comes is its late echo, limited too.
TEST_F(BusMisfit, ALateLimitedEchoAnswersNoLaterWrite) {
  drive::Device limiting = limiting_axis();
  limiting.timing.quarantine = 0ms;
  open(settings(), {limiting});
  ask(kSetPoint);
  advance(200ms);
  ASSERT_THAT(endings_, ElementsAre(Ending::no_answer));
  ask("06 0005 1770");
  ASSERT_THAT(frames_, SizeIs(2));
  line(kLimited);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  EXPECT_EQ(bus_->counters().late_responses, 1U);
  line(kLimited);  // its own, at last
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
}

TEST_F(BusMisfit, ALimitedEchoAnswersAnyTryOfItsWrite) {
  drive::Device limiting = limiting_axis();
  limiting.timing.retry_writes = true;
  limiting.timing.retries = 1;
  open(settings(), {limiting});
  ask(kSetPoint);
  for (int waited = 0; frames_.size() < 2 && waited < 500; ++waited) {
    advance(1ms);
  }
  ASSERT_THAT(endings_, IsEmpty());
  advance(10ms);
  line(kLimited);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
}

TEST_F(BusMisfit, ALimitedEchoIsNotTooEarly) {
  drive::Device limiting = limiting_axis();
  limiting.timing.response_wait = 4ms;
  open(settings(), {limiting});
  ask(kSetPoint);
  line(kLimited);
  EXPECT_THAT(endings_, ElementsAre(Ending::answered));
  EXPECT_EQ(bus_->counters().early_responses, 0U);
}

// Two stops by values of their own: what comes is late, and is the echo of the first.
TEST_F(BusMisfit, ALimitedEchoAcknowledgesNoStop) {
  drive::Device limiting = limiting_axis();
  limiting.timing.stop_retries = 0;
  limiting.profile.stops = {{modbus::Table::holding_registers, 5, 0xF000, 0x2000}};
  open(settings(), {limiting});
  ask(kSetPoint);
  line(kLimited);
  EXPECT_THAT(endings_, IsEmpty());
  advance(20ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
}

// It was heard; the answer to a read cannot be mistaken for that to the write.
TEST_F(BusMisfit, AReadNeedNotWaitUntilTheResponseTimeoutOfTheWriteIsOver) {
  auto patient = settings();
  patient.timing.response_timeout = 1s;
  open(patient);
  ask(kSetPoint);
  line(kLimited);
  submit(job(kRead));
  advance(30ms);
  EXPECT_EQ(frames_.back(), kReadFrame);
}

// A late answer that lay there when the next request left says nothing of that request.
TEST_F(BusMisfit, AFrameThatCameBeforeTheRequestIsNone) {
  auto patient = settings();
  patient.frame_slack = 200ms;
  patient.timing.quarantine = 0ms;
  open(patient);
  ask("08 0000 1234");
  advance(patient.timing.response_timeout + 10ms);
  line("01 08 0000 0001 21 CB");
  advance(100ms);
  submit(job(kRead));
  advance(patient.timing.response_timeout - 1ms);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer));
  line(kAnswer);
  EXPECT_THAT(endings_, ElementsAre(Ending::no_answer, Ending::answered));
  EXPECT_THAT(notices_, testing::Not(testing::Contains(Kind::misfit)));
}

}  // namespace
}  // namespace mbgate::test
