// SPDX-License-Identifier: Apache-2.0
// Bytes before an answer that are no part of it.
#include "modbus/frames.hpp"
#include "rtu_framer_rig.hpp"

namespace mbgate::test::rtu_noise_test {
namespace {

constexpr auto kRead = "03 001E 0002";
const std::string kAnswer = "01 03 04 00 03 0D 40 0F 53";

/// With its CRC.
std::string frame(std::string_view bytes) {
  auto whole = unhex(bytes);
  const auto crc = modbus::crc16(whole);
  whole.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  whole.push_back(static_cast<std::uint8_t>(crc >> 8U));
  return hex(whole);
}

class RtuNoise : public RtuRig {
 protected:
  /// One byte at a time, as fast as the line carries them.
  Verdict trickle(std::string_view bytes) {
    Verdict verdict = Verdict::none;
    for (const std::uint8_t byte : unhex(bytes)) {
      EXPECT_EQ(verdict, Verdict::none);
      now_ += 573us;
      verdict = framer_.add({&byte, 1}, now_);
    }
    return verdict;
  }
};

TEST_F(RtuNoise, OfAnyValueIsSkipped) {
  std::size_t skipped = 0;
  for (const auto* noise : {"00", "FF", "FE", "F8", "C0", "80", "7F", "01", "03", "01 03", "FE 7F",
                            "F8 01", "C0 10", "80 03 FF", "00 FF 00 FE F8 C0 80"}) {
    expect(kRead);
    const Verdict verdict = add(noise + (" " + kAnswer));
    EXPECT_EQ(verdict == Verdict::none ? after(20ms) : verdict, Verdict::response) << noise;
    EXPECT_EQ(framer_.found().noise, unhex(noise).size());
    skipped += framer_.found().noise;
    EXPECT_EQ(response(), "03 04 00 03 0D 40");
  }
  EXPECT_EQ(counters_.noise_bytes, skipped);
  EXPECT_EQ(counters_.stray_bytes, 0U);
}

TEST_F(RtuNoise, IsSkippedByteByByteToo) {
  for (const auto* noise : {"FE", "F8", "C0", "80", "7F", "80 C0 7F FE F8 00 FF"}) {
    expect(kRead);
    EXPECT_EQ(trickle(noise + (" " + kAnswer)), Verdict::response) << noise;
  }
}

TEST_F(RtuNoise, OfMoreThanSevenBytesIsNotSkipped) {
  struct Case {
    const char* asked;  // of eight bytes, and of more
    std::string answer;
  };
  for (const Case& it :
       {Case{kRead, kAnswer}, Case{"10 001E 0001 02 0001", frame("01 10 001E 0001")}}) {
    expect(it.asked);
    EXPECT_EQ(add("FE FE FE FE FE FE FE " + it.answer), Verdict::response);
    expect(it.asked);
    EXPECT_EQ(add("FE FE FE FE FE FE FE FE " + it.answer), Verdict::none);
    EXPECT_EQ(after(100ms), Verdict::none);
    EXPECT_FALSE(framer_.in_progress());
  }
}

TEST_F(RtuNoise, OfMoreThanSevenBytesIsNotSkippedBeforeAFrameThatNobodyWaitsForEither) {
  for (const bool is_more : {false, true}) {
    framer_.listen();
    add("FE FE FE FE FE FE FE " + std::string(is_more ? "FE " : "") + kAnswer);
    EXPECT_EQ(framer_.take_unsolicited().has_value(), !is_more);
  }
}

// Nor where the end of a wait has cut the frame behind it.
TEST_F(RtuNoise, NorBeforeOneThatWasCut) {
  const std::string noise = "02 03 20 05 05 05 05";
  for (const bool is_more : {false, true}) {
    framer_.listen();
    add(noise + (is_more ? " 05" : "") + " 01 03 04 00");
    framer_.listen();
    add("03 0D 40 0F 53");
    EXPECT_EQ(framer_.take_unsolicited().has_value(), !is_more);
  }
}

// A bit of it is wrong: it asked for two registers from 001A on, and this answers that.
TEST_F(RtuNoise, IsNotTheRequestOfAnotherClient) {
  expect(kRead);
  EXPECT_EQ(add("01 03 00 1B 00 02 E5 CC " + kAnswer), Verdict::none);
  EXPECT_EQ(after(100ms), Verdict::none);
}

// Coils 653 to 668: the echo of this request begins with an answer to it, which has a good CRC.
TEST_F(RtuNoise, IsNotFollowedByAnEchoThatLooksLikeTheAnswer) {
  constexpr auto kEcho = "04 01 02 8D 00 10 AC 00";
  constexpr auto kLooksLikeIt = "04 01 02 8D 00 10 AC";
  constexpr auto kCoils = "01 028D 0010";
  expect(kCoils, 4);
  EXPECT_EQ(add(std::string("FF 00 00 FF ") + kEcho), Verdict::none);
  EXPECT_FALSE(framer_.in_progress());
  EXPECT_EQ(counters_.stray_bytes, 4U + 8U);
  EXPECT_EQ(add(frame("04 01 02 12 34")), Verdict::response);
  EXPECT_EQ(response(), "01 02 12 34");
  EXPECT_FALSE(framer_.take_unsolicited());
  expect(kCoils, 4);
  EXPECT_EQ(add(kLooksLikeIt), Verdict::none);
  EXPECT_EQ(add("00"), Verdict::none);
  EXPECT_EQ(after(100ms), Verdict::none);
  expect(kCoils, 4);
  EXPECT_EQ(add(kLooksLikeIt), Verdict::none);
  EXPECT_EQ(after(20ms), Verdict::response);
  EXPECT_EQ(response(), "01 02 8D 00");
}

// The request of a queue has six bytes only. It asked for that at 04DE.
TEST_F(RtuNoise, IsNoShortRequestEither) {
  expect("18 04DF");
  EXPECT_EQ(add("01 18 04 DF 03 47 01 18 00 06 00 02 11 11 22 22 59 82"), Verdict::none);
  EXPECT_EQ(after(100ms), Verdict::none);
}

TEST_F(RtuNoise, BeforeSilenceDoesNotCount) {
  expect(kRead);
  EXPECT_EQ(add("55 55 55 55 55 55 55 01"), Verdict::none);
  now_ += 3ms;
  EXPECT_EQ(add("FE FE FE FE FE FE " + kAnswer), Verdict::response);
}

TEST_F(RtuNoise, DoesNotDateTheAnswer) {
  expect(kRead);
  EXPECT_EQ(add("01"), Verdict::none);  // a glitch while we transmit, and like our device's address
  now_ += 50ms;
  const Instant began = now_;
  EXPECT_EQ(add("FE 01 03 04 00 03"), Verdict::none);
  now_ += 3ms;
  EXPECT_EQ(add("0D 40 0F 53"), Verdict::response);
  EXPECT_EQ(framer_.found().began, began);
}

TEST_F(RtuNoise, BeforeAnExceptionNeedsSilenceBehindIt) {
  expect(kRead);
  EXPECT_EQ(add("FE 01 83 02 C0 F1"), Verdict::none);
  EXPECT_TRUE(framer_.in_progress());
  EXPECT_EQ(after(19ms), Verdict::none);
  EXPECT_EQ(after(1ms), Verdict::response);
  EXPECT_EQ(response(), "83 02");
  expect(kRead);
  EXPECT_EQ(add("FE 01 83 02 C0 F1 55"), Verdict::none);
  EXPECT_EQ(after(20ms), Verdict::none);
  EXPECT_EQ(counters_.unsolicited_frames, 0U);
}

TEST_F(RtuNoise, BeforeAnUnknownFunctionIsNotSkipped) {
  expect("46 01 02");
  EXPECT_EQ(add("FE " + frame("01 46 AA BB")), Verdict::none);
  EXPECT_EQ(after(100ms), Verdict::none);
  EXPECT_FALSE(framer_.in_progress());
}

TEST_F(RtuNoise, BeforeAnAnswerThatTellsItsLengthLateIsSkipped) {
  expect("2B 0E 01 00");
  EXPECT_EQ(add("FF 01 2B 0E 01"), Verdict::none);
  EXPECT_TRUE(framer_.in_progress());
  EXPECT_EQ(after(20ms), Verdict::none);
  EXPECT_EQ(add("01 00 00 01 00 02 41 42 96 ED"), Verdict::response);
}

TEST_F(RtuNoise, BeforeADamagedAnswerIsToldFromIt) {
  expect(kRead);
  EXPECT_EQ(add("FE F8 01 03 04 00 03 0D 41 0F 53"), Verdict::none);
  EXPECT_EQ(after(20ms), Verdict::damaged);
  EXPECT_EQ(framer_.found().noise, 2U);
  expect("46 01 02");
  EXPECT_EQ(add("01 46 AA BB 00 00"), Verdict::none);
  EXPECT_EQ(after(20ms), Verdict::damaged);
  EXPECT_EQ(framer_.found().noise, 0U);
}

TEST_F(RtuNoise, NothingIsTakenOutOfTheFrameOfAnotherUnit) {
  const std::string outer = frame("05 03 0E " + kAnswer + " 11 22 33 44 55");
  for (const bool at_once : {true, false}) {
    expect(kRead);
    EXPECT_EQ(at_once ? add(outer) : trickle(outer), Verdict::none);
    EXPECT_EQ(after(100ms), Verdict::none);
    EXPECT_EQ(framer_.take_unsolicited()->address, 5);
  }
  EXPECT_EQ(counters_.unsolicited_frames, 2U);
}

// Once in 65,536 times they have a good CRC together with the beginning of what follows.
TEST_F(RtuNoise, GivenUpIsNotJoinedWithAnAnswer) {
  EXPECT_EQ(add("02 03 04 D9 97"), Verdict::none);
  now_ += 10ms;
  expect("03 0000 0001");
  EXPECT_EQ(add("01 03 02 12 34 B5 33"), Verdict::response);
}

TEST_F(RtuNoise, NorWithAGoodFrameThatNobodyWaitsFor) {
  framer_.listen();
  add("02 03 04 D9 97");
  now_ += 10ms;
  add("01 03 02 12 34 B5 33");
  const auto unsolicited = framer_.take_unsolicited();
  ASSERT_TRUE(unsolicited);
  EXPECT_EQ(unsolicited->address, 1);
}

// The longest frame takes 147 ms, and may have pauses of one second.
TEST_F(RtuNoise, BehindAnAnswerThatOnlySilenceEndsMakesItNone) {
  expect("41 01");
  EXPECT_EQ(add("01 41 12"), Verdict::none);
  for (int times = 0; times < 76; ++times) {
    EXPECT_EQ(after(15ms), Verdict::none);
    EXPECT_TRUE(framer_.in_progress());
    EXPECT_EQ(add("FF"), Verdict::none);
  }
  EXPECT_EQ(after(15ms), Verdict::damaged);
}

// The process was not there for so long; what it reads then lay there together.
TEST_F(RtuNoise, IsNotWhatWasReadLate) {
  expect("03 0000 0001");
  EXPECT_EQ(add("01 03 02"), Verdict::none);
  now_ += 500ms;
  EXPECT_EQ(add("12 34 B5 34"), Verdict::none);
  EXPECT_EQ(after(20ms), Verdict::damaged);
}

TEST_F(RtuNoise, WhatMayBeAPartOfAnotherFrameWaitsForSilence) {
  expect(kRead);
  EXPECT_EQ(add("05 03 0E " + kAnswer), Verdict::none);
  EXPECT_EQ(after(19ms), Verdict::none);
  EXPECT_EQ(after(1ms), Verdict::response);
}

// Without silence between, it answers what the other client asked.
TEST_F(RtuNoise, WhatFollowsAnotherClientsRequestIsNoAnswer) {
  for (const auto* request : {"01 03 001E 0002", "01 10 001E 0002 04 0001 0002", "05 11"}) {
    expect(kRead);
    EXPECT_EQ(add(frame(request) + " " + kAnswer), Verdict::none) << request;
    EXPECT_EQ(after(100ms), Verdict::none);
    const auto unsolicited = framer_.take_unsolicited();
    ASSERT_TRUE(unsolicited);
    EXPECT_FALSE(unsolicited->is_response);
    framer_.listen();
    EXPECT_FALSE(framer_.take_unsolicited());  // nor does it tell anything of what is owed
  }
}

TEST_F(RtuNoise, AStrayFrameBehindItMayBeOneByChanceOnly) {
  framer_.listen();
  EXPECT_EQ(add("FE F8 " + kAnswer), Verdict::none);
  const auto after_noise = framer_.take_unsolicited();
  ASSERT_TRUE(after_noise);
  EXPECT_TRUE(after_noise->after_noise);
  EXPECT_EQ(counters_.noise_bytes, 2U);
  now_ += 5ms;
  EXPECT_EQ(add(kAnswer), Verdict::none);
  EXPECT_FALSE(framer_.take_unsolicited()->after_noise);
}

TEST_F(RtuNoise, NeverMakesAnAnswerOfACandidateUnderWay) {
  expect("03 001E 0009");
  // Eighteen bytes of data that hold a whole answer's beginning.
  EXPECT_EQ(trickle(frame("01 03 12 01 03 12 01 03 12 01 03 12 01 03 12 01 03 12 01 03 12")),
            Verdict::response);
  EXPECT_EQ(framer_.found().noise, 0U);
}

}  // namespace
}  // namespace mbgate::test::rtu_noise_test
