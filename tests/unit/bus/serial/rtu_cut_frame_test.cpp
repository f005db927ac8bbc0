// SPDX-License-Identifier: Apache-2.0
// Frames that nobody waits for, in portions: what silence, or the end of a wait, has cut.
#include "rtu_framer_rig.hpp"

namespace mbgate::test {
namespace {

class RtuCutFrame : public RtuRig {
 protected:
  static constexpr auto kRead = "03 001E 0002";
  static constexpr auto kAnswer = "01 03 04 00 03 0D 40 0F 53";
  /// These bytes, a pause, and the answer, which the end of a wait cuts.
  auto cut_behind(std::string_view before) {
    framer_.listen();
    add(before);
    after(16ms);
    add("01 03 04 00");
    framer_.listen();
    add("03 0D 40 0F 53");
    return framer_.take_unsolicited();
  }
};

TEST_F(RtuCutFrame, AFrameThatNobodyWaitsForMayPauseForTheSlackToo) {
  framer_.listen();
  add("01 03 04 00");
  after(16ms);
  add("03 0D");
  after(16ms);
  add("40 0F 53");
  const auto unsolicited = framer_.take_unsolicited();
  ASSERT_TRUE(unsolicited);
  EXPECT_EQ(unsolicited->address, 1);
  EXPECT_TRUE(unsolicited->is_response);
  EXPECT_EQ(hex(unsolicited->pdu.bytes()), "03 04 00 03 0D 40");
  EXPECT_EQ(unsolicited->came, now_);
  EXPECT_FALSE(framer_.take_unsolicited());
}

TEST_F(RtuCutFrame, SoMayOneOfAnotherDeviceBeforeTheAnswer) {
  expect(kRead);
  for (const auto* part : {"02 03 0E 00 07", "FF EE DD CC BB AA 99 88 77 66", "55 44 C9 19"}) {
    EXPECT_EQ(add(part), Verdict::none);
    after(16ms);
  }
  const auto unsolicited = framer_.take_unsolicited();
  ASSERT_TRUE(unsolicited);
  EXPECT_EQ(unsolicited->address, 2);
  EXPECT_EQ(add("01 03 04 00 03 0D 40 0F 53"), Verdict::response);
}

/// At 4800 baud the rest of a frame may take longer than `frame_slack`.
TEST_F(RtuCutFrame, ItsRestMayTakeLongerThanAPause) {
  expect(kRead);
  EXPECT_EQ(add("02 03"), Verdict::none);
  framer_.listen();
  for (const auto* byte : {"0E", "00", "07", "FF", "EE", "DD", "CC", "BB", "AA", "99", "88", "77",
                           "66", "55", "44", "C9", "19"}) {
    after(1500us);
    EXPECT_FALSE(framer_.take_unsolicited());
    add(byte);
  }
  EXPECT_TRUE(framer_.take_unsolicited());
}

TEST_F(RtuCutFrame, WhatComesBehindTheRestOfACutFrameIsSearched) {
  framer_.listen();
  add("02 03 04 00");
  after(5ms);
  expect(kRead);
  EXPECT_EQ(add("03 0D"), Verdict::none);
  EXPECT_EQ(add("40 3C 53 01 03 04 00 03 0D 40 0F 53"), Verdict::response);
  EXPECT_EQ(response(), "03 04 00 03 0D 40");
  ASSERT_TRUE(framer_.take_unsolicited());
}

// The second counts from its last byte.
TEST_F(RtuCutFrame, WhatComesAfterASecondIsNoRestOfIt) {
  framer_.listen();
  for (const Duration pause : {1000ms, 1001ms}) {
    add("01 03");
    after(1ms);
    add("04 00");
    after(pause);
    add("03 0D 40 0F 53");
    EXPECT_EQ(framer_.take_unsolicited().has_value(), pause == 1s);
    after(2s);
  }
}

/// At 1200 baud a single byte takes longer than a `frame_slack` of 5 ms.
TEST_F(RtuCutFrame, ButNoSilenceIsNoPause) {
  framer_.set_slack(1ms);
  framer_.listen();
  add("01 03 04 00");
  framer_.listen();
  after(1500us);
  add("03 0D 40 0F 53");
  EXPECT_TRUE(framer_.take_unsolicited());
}

TEST_F(RtuCutFrame, ABitOfNoiseBeforeWhatWasCutIsNoPartOfIt) {
  const auto unsolicited = cut_behind("B6");
  ASSERT_TRUE(unsolicited);
  EXPECT_EQ(unsolicited->address, 1);
}

// A damaged frame that could be the beginning of a longer one, a pause, and a late answer that the
// end of a wait has cut.
TEST_F(RtuCutFrame, NorIsWhatCameShortlyBefore) {
  const auto unsolicited = cut_behind("02 03 20 00 07 FF EE DD CC BB AA 99 88");
  ASSERT_TRUE(unsolicited);
  EXPECT_EQ(unsolicited->address, 1);
  EXPECT_FALSE(unsolicited->after_noise);
}

// One that has lost bytes, in as many pieces as it has: each is given up.
TEST_F(RtuCutFrame, NorIsWhatCameBeforeInManyPieces) {
  framer_.listen();
  for (int byte = 0; byte < 40; ++byte) {
    add(byte == 0 ? "18" : byte == 1 ? "04" : "2A");
    after(16ms);
  }
  add("01 03 04 00");
  after(16ms);
  add("03 0D 40 0F 53");
  const auto unsolicited = framer_.take_unsolicited();
  ASSERT_TRUE(unsolicited);
  EXPECT_EQ(unsolicited->address, 1);
  EXPECT_FALSE(unsolicited->after_noise);
}

// Long ones: together they are longer than any frame. Their unequal lengths tell where each begins.
TEST_F(RtuCutFrame, NorIsALongOneThatCameBefore) {
  std::vector<std::uint8_t> answer(226);
  answer[0] = 3;
  answer[1] = 224;
  const auto late = modbus::encode_rtu(1, *modbus::Pdu::from(answer));
  framer_.listen();
  for (int piece = 0; piece < 17; ++piece) {
    add(piece == 0 ? "18 04 F8" : "18 04 F8 00 00 00 00 00 00 00");
    after(16ms);
  }
  std::size_t begin = 0;
  for (const std::size_t end : {std::size_t{12}, std::size_t{84}, std::size_t{156}, late.size()}) {
    EXPECT_FALSE(framer_.take_unsolicited());
    FramerRig::add(modbus::Bytes(late.data() + begin, end - begin));
    after(16ms);
    begin = end;
  }
  const auto unsolicited = framer_.take_unsolicited();
  ASSERT_TRUE(unsolicited);
  EXPECT_EQ(unsolicited->address, 1);
  EXPECT_FALSE(unsolicited->after_noise);
}

// An identification that never ends: there is no room for its rest.
TEST_F(RtuCutFrame, AFrameLongerThanAnyIsNotCompleted) {
  std::vector<std::uint8_t> endless = unhex("01 2B 0E 01 01 00 00 FF");
  endless.resize(modbus::kMaxRtuSize);
  framer_.listen();
  add("01 03 04 00");
  framer_.listen();
  FramerRig::add(endless);
  framer_.listen();
  add("00");
  EXPECT_FALSE(framer_.take_unsolicited());
}

// It was 01, and so does the answer begin.
TEST_F(RtuCutFrame, ALostLastByteIsNotTakenFromTheAnswer) {
  framer_.listen();
  add("02 03 02 00 F3 BC");
  after(5ms);
  expect(kRead);
  EXPECT_EQ(add("01 03 04 00 03 0D"), Verdict::none);
  EXPECT_EQ(add("40 0F 53"), Verdict::response);
}

// By chance it has a good CRC without its last byte.
TEST_F(RtuCutFrame, ItsLengthTellsThatItIsCut) {
  framer_.listen();
  add("04 03 08 4F 69 65 D1 EE 3A 31 55 0C");
  framer_.listen();
  EXPECT_FALSE(framer_.take_unsolicited());
  add("00");
  const auto unsolicited = framer_.take_unsolicited();
  ASSERT_TRUE(unsolicited);
  EXPECT_TRUE(unsolicited->is_response);
}

TEST_F(RtuCutFrame, OneByteMayBeAllThatWasCutOff) {
  framer_.listen();
  add("01");
  after(16ms);
  add("03 04 00 03 0D 40 0F 53");
  ASSERT_TRUE(framer_.take_unsolicited());
}

// Behind an answer nothing is searched any more: a whole frame may stand there, and more.
TEST_F(RtuCutFrame, AFrameThatWasWholeIsNotJoined) {
  expect(kRead);
  EXPECT_EQ(add(std::string(kAnswer) + "06 10 00 7A 00 04 E1 A4 06 06 00 96 50 02"),
            Verdict::response);
  framer_.listen();
  after(1ms);
  add("6C E2 4C 95 1D");
  EXPECT_FALSE(framer_.take_unsolicited());
}

TEST_F(RtuCutFrame, WhatWasCutIsNoPartOfTheAnswerBehindIt) {
  framer_.listen();
  add("01 03 04 00");
  after(5ms);
  expect(kRead);
  EXPECT_EQ(add(kAnswer), Verdict::response);
  EXPECT_FALSE(framer_.take_unsolicited());
}

// Another client asks the same device for two registers from 0064 on. What follows answers that.
TEST_F(RtuCutFrame, WhatFollowsAnotherClientsCutRequestIsNoAnswer) {
  expect(kRead);
  EXPECT_EQ(add("01 03 00 64"), Verdict::none);
  EXPECT_EQ(after(16ms), Verdict::none);
  EXPECT_EQ(add("00 02 85 D4 01 03 04 AA BB CC DD 3E 97"), Verdict::none);
  EXPECT_EQ(after(100ms), Verdict::none);
}

TEST_F(RtuCutFrame, WhatLooksLikeTheBeginningOfTheAnswerMayBeAPartOfIt) {
  for (const auto* last : {"00", "01"}) {
    expect(kRead);
    EXPECT_EQ(add("02 03 04 00 " + std::string(last)), Verdict::none);
    after(16ms);
    EXPECT_EQ(add("0D 40 " + std::string(last[1] == '1' ? "9D 93" : "CC 53")), Verdict::none);
    const auto unsolicited = framer_.take_unsolicited();
    ASSERT_TRUE(unsolicited) << last;
    EXPECT_EQ(unsolicited->address, 2);
  }
}

// The length, the CRC or a pause shows that it is no answer.
TEST_F(RtuCutFrame, SoMayItsUnitAndFunction) {
  constexpr auto kWrite = "06 001E 0D40";
  struct Late {
    const char* asked;
    const char* begin;
    const char* rest;
  };
  for (const Late& late :
       {Late{kRead, "02 03 04 01 03", "0D 40 3D AF"}, Late{kRead, "02 03 04 01 03", "04 40 3B FF"},
        Late{kRead, "02 03 04 01 83", "0D 40 3C 47"},
        Late{kRead, "02 01 07 01 03", "04 00 07 0D 40 C8 29"},
        Late{kRead, "02 01 03", "04 00 07 3C 7E"}, Late{kWrite, "02 03 04 01 06", "0D 40 2D AE"}}) {
    expect(late.asked);
    EXPECT_EQ(add(late.begin), Verdict::none);
    EXPECT_EQ(after(16ms), Verdict::none);
    EXPECT_EQ(add(late.rest), Verdict::none);
    const Instant came = now_;
    EXPECT_EQ(after(100ms), Verdict::none);
    const auto unsolicited = framer_.take_unsolicited();
    ASSERT_TRUE(unsolicited) << late.begin << ' ' << late.rest;
    EXPECT_EQ(unsolicited->address, 2);
    EXPECT_EQ(unsolicited->came, came);
    EXPECT_FALSE(framer_.in_progress());
  }
}

// Five bytes behind noise look like an exception too often, as they do before an answer.
TEST_F(RtuCutFrame, AnExceptionBehindNoiseIsNone) {
  framer_.listen();
  add("B6 01 83");
  framer_.listen();
  add("02 C0 F1");
  EXPECT_FALSE(framer_.take_unsolicited());
}

TEST_F(RtuCutFrame, AnExceptionBehindAPauseIsOne) {
  framer_.listen();
  add("B6");
  after(16ms);
  add("01 83");
  framer_.listen();
  add("02 C0 F1");
  EXPECT_TRUE(framer_.take_unsolicited());
}

TEST_F(RtuCutFrame, WhatStandsBehindNoiseIsToldAsThat) {
  for (const auto* noise : {"", "B6"}) {
    framer_.listen();
    add(noise + std::string("01 03 04 00"));
    framer_.listen();
    add("03 0D 40 0F 53");
    EXPECT_EQ(framer_.take_unsolicited().value().after_noise, *noise != '\0');
  }
}

}  // namespace
}  // namespace mbgate::test
