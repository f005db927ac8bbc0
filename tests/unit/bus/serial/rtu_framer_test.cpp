// SPDX-License-Identifier: Apache-2.0
#include "modbus/frames.hpp"
#include "rtu_framer_rig.hpp"

namespace mbgate::test::rtu_framer_test {
namespace {

using RtuFramer = RtuRig;

constexpr auto kRead = "03 001E 0002";
constexpr auto kAnswer = "01 03 04 00 03 0D 40 0F 53";

TEST_F(RtuFramer, TakesAnAnswerAtItsLastByte) {
  expect(kRead);
  EXPECT_EQ(add("01 03 04 00 03 0D 40 0F"), Verdict::none);
  EXPECT_EQ(add("53"), Verdict::response);
  EXPECT_EQ(response(), "03 04 00 03 0D 40");
}

TEST_F(RtuFramer, GapsWithinAnAnswerMeanNothing) {
  for (std::size_t cut = 1; cut < 9; ++cut) {
    expect(kRead);
    const auto bytes = unhex(kAnswer);
    EXPECT_EQ(framer_.add(modbus::Bytes(bytes).first(cut), now_), Verdict::none);
    now_ += 16ms;  // an adapter's latency timer
    EXPECT_EQ(framer_.add(modbus::Bytes(bytes).subspan(cut), now_), Verdict::response) << cut;
  }
}

TEST_F(RtuFramer, TakesAnExceptionAtOnce) {
  expect(kRead);
  EXPECT_EQ(add("01 83 02 C0 F1"), Verdict::response);
  EXPECT_EQ(response(), "83 02");
}

TEST_F(RtuFramer, NoiseIsAllowedBeforeEachFrame) {
  expect(kRead);
  EXPECT_EQ(add("00"), Verdict::none);  // our own driver turning off
  now_ += 5ms;
  EXPECT_EQ(add(std::string("FF FF ") + kAnswer), Verdict::response);
}

TEST_F(RtuFramer, TakesTheLongestAnswerWithNoiseAroundIt) {
  expect("03 0000 007D");
  std::string answer = "01 03 FA";
  for (int byte = 0; byte < 250; ++byte) {
    answer += " 11";
  }
  auto bytes = unhex(answer);
  const auto crc = modbus::crc16(bytes);
  bytes.insert(bytes.begin(), {0x00, 0xFF});
  bytes.insert(bytes.end(), {static_cast<std::uint8_t>(crc & 0xFFU),
                             static_cast<std::uint8_t>(crc >> 8U), 0x00});
  EXPECT_EQ(framer_.add(bytes, now_), Verdict::response);
}

TEST_F(RtuFramer, IgnoresAnswersOfOtherUnitsAndFunctions) {
  expect(kRead);
  EXPECT_EQ(add("02 03 04 00 03 0D 40 3C 53"), Verdict::none);  // unit 2
  EXPECT_EQ(add("01 04 04 00 03 0D 40 0E E4"), Verdict::none);  // function 4
  EXPECT_EQ(add(kAnswer), Verdict::response);
  EXPECT_EQ(counters_.unsolicited_frames, 2U);
}

TEST_F(RtuFramer, LooksBehindThemAtOnce) {
  expect(kRead);
  EXPECT_EQ(add("02 03 04 00 03 0D 40 3C 53" + std::string(kAnswer)), Verdict::response);
}

TEST_F(RtuFramer, IgnoresAnswersOfAnotherLength) {
  expect(kRead);
  EXPECT_EQ(add("01 03 02 12 34 B5 33"), Verdict::none);
  EXPECT_EQ(add(kAnswer), Verdict::response);
  EXPECT_EQ(counters_.unsolicited_frames, 1U);
}

// A bit of it was flipped, or another request is meant: nobody waits for the rest of 198 bytes.
TEST_F(RtuFramer, AnotherByteCountThanAskedForIsNoAnswerThatHasBegun) {
  expect(kRead);
  EXPECT_EQ(add("01 03"), Verdict::none);
  EXPECT_TRUE(framer_.in_progress());
  EXPECT_EQ(add("C6 00 03 0D"), Verdict::none);
  EXPECT_FALSE(framer_.in_progress());
  EXPECT_EQ(after(3ms), Verdict::none);
  EXPECT_EQ(add(kAnswer), Verdict::response);
}

TEST_F(RtuFramer, IgnoresAWriteEchoedWithAnotherValueOrAddress) {
  expect("06 007C 00E1");
  EXPECT_EQ(add("01 06 00 7C 00 66 C8 38"), Verdict::none);
  EXPECT_EQ(add("01 06 00 7B 00 E1 39 9B"), Verdict::none);
  EXPECT_EQ(add("01 06 00 7C 00 E1 88 5A"), Verdict::response);
  EXPECT_EQ(counters_.unsolicited_frames, 2U);
}

TEST_F(RtuFramer, AnAnswerBeganACharacterBeforeItsFirstByteCame) {
  expect("03 001E 0002");
  framer_.expect(*transaction_, now_);
  const Instant first = now_ + 10ms;
  now_ = first;
  add("01");
  now_ += 10ms;
  EXPECT_EQ(add("03 04 00 03 0D 40 0F 53"), Verdict::response);
  EXPECT_EQ(framer_.found().began,
            first - modbus::RtuTiming(modbus::Baud{19200}, {}).least_duration_of(1));
}

TEST_F(RtuFramer, AFrameBehindTheBeginningOfAnotherMayBeAPartOfIt) {
  expect(kRead);
  EXPECT_EQ(add("02 03 20 00 00 03 03 02 12 34 CC F3"), Verdict::none);
  EXPECT_FALSE(framer_.take_unsolicited());
}

TEST_F(RtuFramer, ABadCrcNeedsSilenceToBeBelieved) {
  expect(kRead);
  EXPECT_EQ(add("01 03 04 00 03 0D 41 0F 53"), Verdict::none);
  EXPECT_EQ(after(19ms), Verdict::none);
  EXPECT_EQ(after(1ms), Verdict::damaged);
}

TEST_F(RtuFramer, ABadCrcWithMoreBytesBehindItIsGarbage) {
  expect(kRead);
  EXPECT_EQ(add("01 03 04 00 03 0D 41 0F 53"), Verdict::none);
  EXPECT_EQ(add("55"), Verdict::none);
  EXPECT_EQ(after(100ms), Verdict::none);
  EXPECT_FALSE(framer_.in_progress());
  EXPECT_EQ(add(kAnswer), Verdict::response);
  EXPECT_EQ(counters_.stray_bytes, 10U);
}

// 7 bytes take 4 ms.
TEST_F(RtuFramer, WhatEndsBehindTheFunctionIsWaitedForAsLongAsTheExpectedAnswer) {
  expect("03 0000 0001");
  EXPECT_EQ(add("01 03"), Verdict::none);
  after(23ms);
  EXPECT_TRUE(framer_.in_progress());
  after(2ms);
  EXPECT_FALSE(framer_.in_progress());
}

TEST_F(RtuFramer, UnknownFunctionsEndBySilenceWithAGoodCrc) {
  expect("46 01 02");  // FDA6000's JOG
  EXPECT_EQ(add("01 46 AA BB"), Verdict::none);
  now_ += 10ms;
  EXPECT_EQ(add("CC"), Verdict::none);
  const auto crc = modbus::crc16(unhex("01 46 AA BB CC"));
  const std::uint8_t tail[] = {static_cast<std::uint8_t>(crc & 0xFFU),
                               static_cast<std::uint8_t>(crc >> 8U)};
  EXPECT_EQ(framer_.add(tail, now_), Verdict::none);
  EXPECT_EQ(after(19ms), Verdict::none);
  EXPECT_EQ(after(1ms), Verdict::response);
  EXPECT_EQ(response(), "46 AA BB CC");
}

TEST_F(RtuFramer, WhatSilenceEndsAndIsOfAnotherKindIsNoAnswer) {
  expect("2B 0D 01 02");  // CANopen
  EXPECT_EQ(add("01 2B 0C AA F4 AF"), Verdict::none);
  EXPECT_TRUE(framer_.in_progress());
  EXPECT_EQ(after(20ms), Verdict::none);
  EXPECT_FALSE(framer_.in_progress());
  const auto unsolicited = framer_.take_unsolicited();
  ASSERT_TRUE(unsolicited);
  EXPECT_EQ(hex(unsolicited->pdu.bytes()), "2B 0C AA");
}

TEST_F(RtuFramer, AnAnswerMayPauseForTheSlackInAll) {
  framer_.set_slack(200ms);
  expect(kRead);
  EXPECT_EQ(add("01 03 04"), Verdict::none);
  EXPECT_EQ(after(100ms), Verdict::none);
  EXPECT_EQ(add("00 03"), Verdict::none);
  EXPECT_EQ(after(100ms), Verdict::none);
  EXPECT_EQ(add("0D 40 0F 53"), Verdict::response);
}

// An adapter hands on what it has every 16 ms: a late answer is cut as any other is.
TEST_F(RtuFramer, SlackIsTheSilenceThatABadCrcNeeds) {
  framer_.set_slack(200ms);
  expect(kRead);
  EXPECT_EQ(add("01 03 04 00 03 0D 41 0F 53"), Verdict::none);
  EXPECT_EQ(after(199ms), Verdict::none);
  EXPECT_EQ(after(1ms), Verdict::damaged);
}

TEST_F(RtuFramer, GivesAnIncompleteAnswerUpAfterTheTimeOfItsBytes) {
  expect(kRead);
  EXPECT_EQ(add("01 03 04 00"), Verdict::none);
  EXPECT_TRUE(framer_.in_progress());
  // nine characters take 5.156 ms, plus 20 ms
  EXPECT_EQ(after(25ms), Verdict::none);
  EXPECT_TRUE(framer_.in_progress());
  EXPECT_EQ(after(200us), Verdict::none);
  EXPECT_FALSE(framer_.in_progress());
  EXPECT_EQ(add(kAnswer), Verdict::response);
}

// Nine characters take 5.156 ms.
TEST_F(RtuFramer, WhileAStopWaitsAnAnswerThatCreepsInHasTheSlackOnly) {
  const Duration wire = modbus::RtuTiming(modbus::Baud{19200}, {}).duration_of(9);
  for (const bool is_stop_waiting : {false, true}) {
    expect(kRead);
    const Instant began = now_;
    EXPECT_EQ(add("01"), Verdict::none);
    if (is_stop_waiting) {
      framer_.hurry(began + 1ms);
    }
    EXPECT_EQ(framer_.next_deadline(), began + wire + 20ms);
    after(19ms);
    EXPECT_EQ(add("03"), Verdict::none);
    EXPECT_EQ(framer_.next_deadline(), is_stop_waiting ? began + wire + 20ms : now_ + 20ms);
  }
  framer_.hurry(now_ + 100ms);
  after(1ms);
  EXPECT_EQ(add("04"), Verdict::none);
  EXPECT_EQ(framer_.next_deadline(), now_ + 20ms);
}

TEST_F(RtuFramer, IsDoneWithAnAnswerThatItHasGivenUp) {
  expect("03 0000 0002");
  EXPECT_EQ(add("01 03 04 00"), Verdict::none);
  ASSERT_NE(framer_.next_deadline(), std::nullopt);
  EXPECT_EQ(after(*framer_.next_deadline() - now_), Verdict::none);
  EXPECT_EQ(framer_.next_deadline(), std::nullopt);
}

TEST_F(RtuFramer, SilenceSeparatesGarbageFromTheAnswer) {
  expect(kRead);
  EXPECT_EQ(add("55 AA 12"), Verdict::none);
  now_ += 3ms;
  EXPECT_EQ(add(kAnswer), Verdict::response);
  EXPECT_EQ(counters_.stray_bytes, 3U);
}

TEST_F(RtuFramer, SoDoesANewQuestion) {
  expect(kRead);
  EXPECT_EQ(add("FE FE FE FE FE FE FE FE FE"), Verdict::none);
  expect(kRead);
  EXPECT_EQ(add(kAnswer), Verdict::response);
}

TEST_F(RtuFramer, SurvivesABabblingLine) {
  expect(kRead);
  const std::vector<std::uint8_t> garbage(200, 0x55);
  for (int pieces = 0; pieces < 50; ++pieces) {
    EXPECT_EQ(framer_.add(garbage, now_), Verdict::none);
    now_ += 1ms;
  }
  now_ += 3ms;
  EXPECT_EQ(add(kAnswer), Verdict::response);
}

TEST_F(RtuFramer, ReadsIdentificationByItsObjects) {
  expect("2B 0E 01 00");
  const auto body = unhex("01 2B 0E 01 01 00 00 01 00 02 41 42");
  const auto crc = modbus::crc16(body);
  EXPECT_EQ(framer_.add(body, now_), Verdict::none);
  const std::uint8_t tail[] = {static_cast<std::uint8_t>(crc & 0xFFU),
                               static_cast<std::uint8_t>(crc >> 8U)};
  EXPECT_EQ(framer_.add(tail, now_), Verdict::response);
}

}  // namespace
}  // namespace mbgate::test::rtu_framer_test
