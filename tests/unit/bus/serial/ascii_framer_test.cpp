// SPDX-License-Identifier: Apache-2.0
#include "ascii_framer_rig.hpp"

namespace mbgate::test::ascii_framer_test {
namespace {

class AsciiFramer : public AsciiRig {};

constexpr auto kRead = "03 0000 0001";
constexpr std::string_view kAnswer = ":0103021234B4\r\n";

TEST_F(AsciiFramer, TakesAnAnswerAtItsLineFeed) {
  expect(kRead);
  EXPECT_EQ(add(kAnswer.substr(0, kAnswer.size() - 1)), Verdict::none);
  EXPECT_EQ(add("\n"), Verdict::response);
  EXPECT_EQ(response(), "03 02 12 34");
}

TEST_F(AsciiFramer, TakesOneThatEndsInALineFeedAloneAtOnce) {
  expect(kRead);
  EXPECT_EQ(add(":0103021234B4\n"), Verdict::response);
  EXPECT_EQ(response(), "03 02 12 34");
}

TEST_F(AsciiFramer, TakesOneThatEndsInACarriageReturnAloneIfNothingFollowsIt) {
  expect(kRead);
  EXPECT_EQ(add(":0103021234B4\r"), Verdict::none);
  EXPECT_TRUE(framer_.in_progress());
  EXPECT_TRUE(framer_.awaits_silence());
  EXPECT_EQ(framer_.next_deadline(), now_ + 20ms);
  EXPECT_EQ(after(20ms), Verdict::response);
  EXPECT_EQ(response(), "03 02 12 34");
}

TEST_F(AsciiFramer, TakesItAsWellIfAnotherFrameFollowsIt) {
  expect(kRead);
  EXPECT_EQ(add(":0103021234B4\r:0203021234B3\r"), Verdict::response);
  framer_.listen();
  const auto other = framer_.take_unsolicited();
  EXPECT_FALSE(other);  // its LF may still come
  framer_.listen();
  ASSERT_TRUE(framer_.take_unsolicited());
  EXPECT_EQ(counters_.stray_bytes, 0U);
}

TEST_F(AsciiFramer, ACarriageReturnOrLineFeedAloneEndsNothingBehindAWrongLrc) {
  for (const std::string_view end : {"\r", "\n"}) {
    expect(kRead);
    EXPECT_EQ(add(":0103021234B5" + std::string(end)), Verdict::none);
    EXPECT_EQ(after(2s), Verdict::none);
    EXPECT_FALSE(framer_.in_progress());
  }
  expect(kRead);
  EXPECT_EQ(add(":0103021234B5\r"), Verdict::none);
  EXPECT_EQ(add("\n"), Verdict::damaged);
}

TEST_F(AsciiFramer, TheLongestAnswerHasRoomForBoth) {
  expect("41 00");
  const std::vector<std::uint8_t> pdu(modbus::kMaxPduSize, 0x41);
  const auto frame = modbus::encode_ascii(1, *modbus::Pdu::from(pdu));
  ASSERT_EQ(frame.size(), modbus::kMaxAsciiSize);
  EXPECT_EQ(FramerRig::add({frame.data(), frame.size()}), Verdict::response);
}

// 15 characters of 10 bits take 15.6 ms at 9600 baud.
TEST_F(AsciiFramer, ItsCharactersHaveASecondBeyondTheirTimeOnTheWireTogether) {
  constexpr Duration kWire = 15625us;
  expect(kRead);
  const Instant began = now_;
  for (const char character : {':', '0', '1'}) {
    EXPECT_EQ(add({&character, 1}), Verdict::none);
    EXPECT_EQ(framer_.next_deadline(), std::min(now_ + 1s, began + kWire + 1s));
    now_ += 400ms;
  }
  EXPECT_EQ(framer_.next_deadline(), began + kWire + 1s);
  EXPECT_EQ(framer_.handle_deadline(began + kWire + 1s), Verdict::none);
  EXPECT_FALSE(framer_.in_progress());
}

TEST_F(AsciiFramer, WhileAStopWaitsTheyHaveTheSlack) {
  constexpr Duration kWire = 15625us;
  expect(kRead);
  EXPECT_EQ(add(":0103"), Verdict::none);
  framer_.hurry(now_ + 1ms);
  EXPECT_EQ(framer_.next_deadline(), now_ + kWire + 20ms);
  framer_.hurry(now_ + 100ms);
  EXPECT_EQ(framer_.next_deadline(), now_ + 100ms);
  expect(kRead);
  EXPECT_EQ(add(":0103"), Verdict::none);
  EXPECT_EQ(framer_.next_deadline(), now_ + 1s);
}

TEST_F(AsciiFramer, OnALineThatKeepsItsPaceAnAnswerBeganWithItsTimeOnTheWire) {
  for (const bool is_paced : {false, true}) {
    expect(kRead);
    framer_.expect(*transaction_, is_paced ? now_ - 1s : Instant::min());
    EXPECT_EQ(add(kAnswer), Verdict::response);
    const Duration on_wire =
        modbus::RtuTiming(modbus::Baud{9600}, {}).least_duration_of(kAnswer.size());
    EXPECT_EQ(framer_.found().began, now_ - (is_paced ? on_wire : 0ns));
  }
}

TEST_F(AsciiFramer, AnAnswerMayComeInPiecesUpToASecondApart) {
  for (std::size_t cut = 1; cut < kAnswer.size() - 1; ++cut) {
    expect(kRead);
    EXPECT_EQ(add(kAnswer.substr(0, cut)), Verdict::none);
    EXPECT_EQ(after(1s - 1ns), Verdict::none);
    EXPECT_EQ(add(kAnswer.substr(cut)), Verdict::response) << cut;
  }
}

TEST_F(AsciiFramer, ACharacterThatIsASecondLateBelongsToNothing) {
  for (std::size_t cut = 1; cut < kAnswer.size() - 1; ++cut) {
    expect(kRead);
    EXPECT_EQ(add(kAnswer.substr(0, cut)), Verdict::none);
    now_ += 1s;
    EXPECT_EQ(add(kAnswer.substr(cut)), Verdict::none) << cut;
    EXPECT_EQ(add(kAnswer), Verdict::response) << cut;
  }
}

TEST_F(AsciiFramer, GivesAnIncompleteAnswerUpAfterASecond) {
  expect(kRead);
  EXPECT_EQ(add(":0103"), Verdict::none);
  EXPECT_TRUE(framer_.in_progress());
  EXPECT_EQ(framer_.next_deadline(), now_ + 1s);
  EXPECT_EQ(after(1s), Verdict::none);
  EXPECT_FALSE(framer_.in_progress());
  EXPECT_EQ(counters_.stray_bytes, 5U);
}

TEST_F(AsciiFramer, AColonBeginsTheFrameAnew) {
  expect(kRead);
  EXPECT_EQ(add(":010302"), Verdict::none);
  EXPECT_EQ(add(kAnswer), Verdict::response);
  EXPECT_EQ(response(), "03 02 12 34");
  EXPECT_EQ(counters_.stray_bytes, 7U);
}

TEST_F(AsciiFramer, SlackIsTheSilenceThatALoneCarriageReturnNeeds) {
  framer_.set_slack(200ms);
  expect(kRead);
  EXPECT_EQ(add(":0103021234B4\r"), Verdict::none);
  EXPECT_EQ(after(199ms), Verdict::none);
  EXPECT_EQ(after(1ms), Verdict::response);
}

TEST_F(AsciiFramer, WhatStandsBeforeTheColonOrBehindTheLineFeedIsStray) {
  expect(kRead);
  EXPECT_EQ(add(std::string("0103\r\n") + std::string(kAnswer) + "xyz"), Verdict::response);
  framer_.listen();
  EXPECT_EQ(counters_.stray_bytes, 9U);
}

TEST_F(AsciiFramer, BytesBeforeTheColonAreNoBeginning) {
  expect(kRead);
  EXPECT_EQ(add("\r\n01"), Verdict::none);
  EXPECT_FALSE(framer_.in_progress());
  EXPECT_EQ(framer_.next_deadline(), std::nullopt);
}

TEST_F(AsciiFramer, UnderstandsSmallLetters) {
  expect("03 0000 0001", 0xAB);
  EXPECT_EQ(add(":ab"), Verdict::none);
  EXPECT_TRUE(framer_.in_progress());
  EXPECT_EQ(add("030212340a\r\n"), Verdict::response);
}

TEST_F(AsciiFramer, TakesAnException) {
  expect(kRead);
  EXPECT_EQ(add(":0183027A\r\n"), Verdict::response);
  EXPECT_EQ(response(), "83 02");
}

TEST_F(AsciiFramer, ABadLrcEndsTheWaitAtOnce) {
  expect(kRead);
  EXPECT_EQ(add(":0103021235B4\r\n"), Verdict::damaged);
}

TEST_F(AsciiFramer, ABadLrcOfAnotherUnitFunctionOrLengthDoesNot) {
  expect(kRead);
  EXPECT_EQ(add(":0203021234B4\r\n"), Verdict::none);
  EXPECT_EQ(add(":0104021234B4\r\n"), Verdict::none);
  EXPECT_EQ(add(":01030412345678B4\r\n"), Verdict::none);
  EXPECT_EQ(add(kAnswer), Verdict::response);
  EXPECT_EQ(counters_.stray_bytes, 15U + 15U + 19U);
  EXPECT_EQ(counters_.unsolicited_frames, 0U);
}

TEST_F(AsciiFramer, GoodFramesThatAnswerSomethingElseAreCounted) {
  expect(kRead);
  EXPECT_EQ(add(":0203021234B3\r\n"), Verdict::none);      // unit 2
  EXPECT_EQ(add(":0104021234B3\r\n"), Verdict::none);      // function 4
  EXPECT_EQ(add(":01030412345678E4\r\n"), Verdict::none);  // two registers
  EXPECT_EQ(add(kAnswer), Verdict::response);
  EXPECT_EQ(counters_.unsolicited_frames, 3U);
  EXPECT_EQ(counters_.stray_bytes, 0U);
}

TEST_F(AsciiFramer, AWriteMustBeEchoed) {
  expect("06 0000 0001");
  EXPECT_EQ(add(":010600000002F7\r\n"), Verdict::none);
  EXPECT_EQ(add(":010600000001F8\r\n"), Verdict::response);
}

TEST_F(AsciiFramer, AFrameOfAnotherUnitIsNoBeginning) {
  expect(kRead);
  EXPECT_EQ(add(":0"), Verdict::none);
  EXPECT_TRUE(framer_.in_progress());
  EXPECT_EQ(add("2"), Verdict::none);
  EXPECT_FALSE(framer_.in_progress());
  EXPECT_EQ(add("03021234B3\r\n"), Verdict::none);
  EXPECT_EQ(add(kAnswer), Verdict::response);
}

TEST_F(AsciiFramer, WhatIsNotHexadecimalIsNoise) {
  for (const auto* noise : {":0103021G34B4\r\n", ":0103021234B\r\n", ":0103021234B5\n", ":\r\n"}) {
    expect(kRead);
    counters_ = {};
    EXPECT_EQ(add(noise), Verdict::none) << noise;
    EXPECT_EQ(counters_.stray_bytes, std::string_view(noise).size()) << noise;
    EXPECT_EQ(add(kAnswer), Verdict::response) << noise;
  }
}

// Else a noisy line that has lost the end of an answer would be waited for as long as it is noisy.
TEST_F(AsciiFramer, NoiseAndMoreThanWasAskedForEndAnAnswerThatHasBegun) {
  for (const auto* more : {"\xFF", "0123456789"}) {
    expect(kRead);
    EXPECT_EQ(add(":01030212"), Verdict::none);
    EXPECT_TRUE(framer_.in_progress());
    EXPECT_EQ(add(more), Verdict::none);
    EXPECT_FALSE(framer_.in_progress()) << more;
    EXPECT_EQ(add(kAnswer), Verdict::response) << more;
  }
}

TEST_F(AsciiFramer, FunctionsOfVendorsEndWithTheirLineFeed) {
  expect("46 01 02");  // FDA6000's JOG
  EXPECT_EQ(add(":0146AABBCC88\r\n"), Verdict::response);
  EXPECT_EQ(response(), "46 AA BB CC");
}

TEST_F(AsciiFramer, TakesTheLongestFrame) {
  expect("46 01 02");
  std::string answer = ":0146";
  for (int byte = 0; byte < 252; ++byte) {
    answer += "00";
  }
  answer += "B9\r\n";
  ASSERT_EQ(answer.size(), modbus::kMaxAsciiSize);
  EXPECT_EQ(add(answer), Verdict::response);
}

TEST_F(AsciiFramer, WhatHasNoRoomForItsLineFeedIsNoFrame) {
  expect(kRead);
  EXPECT_EQ(add(":" + std::string(modbus::kMaxAsciiSize - 2, '0') + "\r"), Verdict::none);
  EXPECT_FALSE(framer_.awaits_silence());
  EXPECT_EQ(add(kAnswer), Verdict::response);
}

TEST_F(AsciiFramer, SurvivesABabblingLine) {
  expect(kRead);
  const std::string babble(600, '0');
  for (int times = 0; times < 50; ++times) {
    EXPECT_EQ(add((times % 2 == 0 ? ":" : "") + babble), Verdict::none);
  }
  EXPECT_EQ(add(kAnswer), Verdict::response);
  EXPECT_EQ(counters_.stray_bytes, 50U * 600U + 25U);
}

TEST_F(AsciiFramer, WhatBeginsBehindAnAnswerGoesOn) {
  constexpr std::string_view kLate = ":02030256782B\r\n";
  for (const std::size_t cut : {std::size_t{5}, kLate.size()}) {
    expect(kRead);
    EXPECT_EQ(add(std::string(kAnswer) + std::string(kLate.substr(0, cut))), Verdict::response);
    framer_.listen();
    EXPECT_EQ(add(kLate.substr(cut)), Verdict::none);
    const auto unsolicited = framer_.take_unsolicited();
    ASSERT_TRUE(unsolicited) << cut;
    EXPECT_EQ(unsolicited->address, 2);
  }
}

TEST_F(AsciiFramer, HoweverManyFramesOfOthersComeBeforeItAnAnswerIsWaitedFor) {
  expect(kRead);
  for (unsigned times = 0; times < 9; ++times) {
    EXPECT_EQ(add(":0203021234B3\r\n"), Verdict::none);
  }
  EXPECT_EQ(add(":0103"), Verdict::none);
  EXPECT_TRUE(framer_.in_progress());
}

}  // namespace
}  // namespace mbgate::test::ascii_framer_test
