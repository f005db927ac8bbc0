// SPDX-License-Identifier: Apache-2.0
#include "modbus/mbap.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

using ::testing::ElementsAreArray;

const auto* const kRead = "00 07 00 00 00 06 01 03 00 1E 00 02";

bool is_incomplete(Bytes stream) {
  return std::holds_alternative<MbapIncomplete>(scan_mbap(stream));
}

/// Takes every ADU off the front, as a connection does; stops where something else lies there.
std::vector<MbapFrame> take_all(std::vector<std::uint8_t>& stream) {
  std::vector<MbapFrame> frames;
  for (;;) {
    const MbapScan scan = scan_mbap(stream);
    const auto* frame = std::get_if<MbapFrame>(&scan);
    if (frame == nullptr) {
      return frames;
    }
    frames.push_back(*frame);
    stream.erase(stream.begin(), stream.begin() + std::ptrdiff_t(frame->size));
  }
}

TEST(MbapScan, AnExceptionHasTwoBytesWhateverItsLengthSays) {
  for (const auto* length : {"00 00", "00 02", "00 04", "00 47", "01 2C"}) {
    auto stream = bytes_of(std::string("00 07 00 00 ") + length + " 01 83");
    EXPECT_TRUE(std::holds_alternative<MbapIncomplete>(scan_mbap_answer(stream)));
    stream.push_back(2);
    stream.push_back(0);
    const auto frame = std::get<MbapFrame>(scan_mbap_answer(stream));
    EXPECT_EQ(frame.adu.header, (MbapHeader{7, 1}));
    EXPECT_EQ(frame.adu.pdu, pdu_of("83 02"));
    EXPECT_EQ(frame.size, 9U);
  }
  EXPECT_TRUE(
      std::holds_alternative<MbapLost>(scan_mbap_answer(bytes_of("00 07 00 00 00 01 01 03"))));
  EXPECT_TRUE(std::holds_alternative<MbapForeign>(
      scan_mbap_answer(bytes_of("00 07 00 01 00 03 01 83 02"))));
}

TEST(MbapScan, FindsHeaderAndPdu) {
  const auto stream = bytes_of(kRead);
  const auto frame = std::get<MbapFrame>(scan_mbap(stream));
  EXPECT_EQ(frame.adu.header, (MbapHeader{7, 1}));
  EXPECT_EQ(frame.adu.pdu, pdu_of("03 00 1E 00 02"));
  EXPECT_EQ(frame.size, 12U);
}

TEST(MbapScan, KeepsEveryBitOfTransactionAndUnit) {
  const auto stream = bytes_of("FE DC 00 00 00 02 FF 07");
  const auto frame = std::get<MbapFrame>(scan_mbap(stream));
  EXPECT_EQ(frame.adu.header, (MbapHeader{0xFEDC, 0xFF}));
  EXPECT_EQ(frame.adu.pdu, pdu_of("07"));
}

TEST(MbapScan, WaitsForMoreBytesWhenSplitAnywhere) {
  const auto whole = bytes_of(kRead);
  EXPECT_TRUE(is_incomplete({}));
  for (std::size_t size = 1; size < whole.size(); ++size) {
    EXPECT_TRUE(is_incomplete(Bytes(whole).first(size))) << size;
  }
}

TEST(MbapScan, TakesCoalescedRequestsOneAfterTheOther) {
  std::vector<std::uint8_t> stream;
  for (unsigned transaction = 0; transaction < 20; ++transaction) {
    auto adu = bytes_of(kRead);
    adu[1] = static_cast<std::uint8_t>(transaction);
    stream.insert(stream.end(), adu.begin(), adu.end());
  }
  stream.insert(stream.end(), {0x00, 0x14, 0x00});
  const auto frames = take_all(stream);
  ASSERT_EQ(frames.size(), 20U);
  for (unsigned transaction = 0; transaction < 20; ++transaction) {
    EXPECT_EQ(frames[transaction].adu.header.transaction, transaction);
  }
  EXPECT_THAT(stream, ElementsAreArray(bytes_of("00 14 00")));
}

TEST(MbapScan, GivesTheSameWhereverTheStreamIsSplit) {
  auto two = bytes_of(kRead);
  const auto second = bytes_of("00 08 00 00 00 0B 0A 10 00 1E 00 02 04 00 00 75 30");
  two.insert(two.end(), second.begin(), second.end());
  for (std::size_t split = 0; split <= two.size(); ++split) {
    const auto middle = two.begin() + std::ptrdiff_t(split);
    std::vector<std::uint8_t> stream(two.begin(), middle);
    auto frames = take_all(stream);
    stream.insert(stream.end(), middle, two.end());
    const auto rest = take_all(stream);
    frames.insert(frames.end(), rest.begin(), rest.end());
    ASSERT_EQ(frames.size(), 2U) << split;
    EXPECT_EQ(frames[0].adu.header.transaction, 7) << split;
    EXPECT_EQ(frames[1].adu.pdu, pdu_of("10 00 1E 00 02 04 00 00 75 30")) << split;
    EXPECT_TRUE(stream.empty()) << split;
  }
}

TEST(MbapScan, LengthIs2To254) {
  EXPECT_EQ(std::get<MbapFrame>(scan_mbap(bytes_of("00 00 00 00 00 02 01 07"))).size, 8U);
  const auto longest = bytes_of("00 00 00 00 00 FE 01 41", 252, 0x55);
  const auto frame = std::get<MbapFrame>(scan_mbap(longest));
  EXPECT_EQ(frame.size, kMaxMbapAduSize);
  EXPECT_EQ(frame.adu.pdu.size(), kMaxPduSize);
}

TEST(MbapScan, FramingIsLostWithAnyOtherLengthAsSoonAsItIsThere) {
  const auto length_of = [](std::string_view hex) {
    return std::get<MbapLost>(scan_mbap(bytes_of(hex))).length;
  };
  EXPECT_EQ(length_of("00 01 00 00 00 00"), 0);
  EXPECT_EQ(length_of("00 01 00 00 00 01"), 1);
  EXPECT_EQ(length_of("00 01 00 00 00 FF"), 255);
  EXPECT_EQ(length_of("00 01 00 00 01 02 01 03"), 258);
  EXPECT_EQ(length_of("00 01 00 00 FF FF"), 65535);
  // A wrong protocol identifier does not make the length sane.
  EXPECT_EQ(length_of("00 01 12 34 FF FF"), 65535);
}

TEST(MbapScan, SkipsExactlyAnAduOfAnotherProtocol) {
  auto stream = bytes_of("00 01 00 01 00 06 01 03 00 1E 00 02");
  const auto next = bytes_of(kRead);
  stream.insert(stream.end(), next.begin(), next.end());
  const auto foreign = std::get<MbapForeign>(scan_mbap(stream));
  EXPECT_EQ(foreign.protocol, 1);
  EXPECT_EQ(foreign.size, 12U);
  const auto frame = std::get<MbapFrame>(scan_mbap(Bytes(stream).subspan(foreign.size)));
  EXPECT_EQ(frame.adu.header.transaction, 7);
}

TEST(MbapScan, WaitsForTheWholeOfAForeignAdu) {
  const auto whole = bytes_of("00 01 FF FF 00 02 01 07");
  for (std::size_t size = 0; size < whole.size(); ++size) {
    EXPECT_TRUE(is_incomplete(Bytes(whole).first(size))) << size;
  }
  EXPECT_EQ(std::get<MbapForeign>(scan_mbap(whole)).protocol, 0xFFFF);
}

TEST(MbapEncode, WritesLengthAndEchoesHeader) {
  const auto bytes = encode({{0xFEDC, 0x0B}, pdu_of("06 00 1D 01 2C")});
  EXPECT_THAT(bytes, ElementsAreArray(bytes_of("FE DC 00 00 00 06 0B 06 00 1D 01 2C")));
}

TEST(MbapEncode, LongestAduHas260Bytes) {
  const auto bytes = encode({{1, 2}, pdu_of(bytes_of("41", 252, 0))});
  EXPECT_EQ(bytes.size(), 260U);
  EXPECT_EQ(load_be16({bytes.data(), bytes.size()}, 4), 254);
}

TEST(OtherProtocol, IsKnownByItsFirstBytes) {
  const auto of = [](std::string_view text) {
    return other_protocol({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
  };
  EXPECT_EQ(of(":010300000001FB\r\n"), "Modbus ASCII");
  EXPECT_EQ(of("\x16\x03\x01\x02"), "TLS");
  EXPECT_EQ(of("GET / HTTP/1.1"), "HTTP");
  EXPECT_EQ(of("OPTIONS * HTTP/1.1"), "HTTP");
  for (const auto* other : {"", "\x16", "GET", "AB /", "get /", "GET/"}) {
    EXPECT_EQ(of(other), "") << other;
  }
}

TEST(LooksLikeRtu, RecognisesRequestsWithTheirCrc) {
  EXPECT_TRUE(looks_like_rtu(bytes_of("01 03 00 1E 00 02 A4 0D")));
  EXPECT_TRUE(looks_like_rtu(bytes_of("0B 06 00 1D 01 2C 19 2B")));
  EXPECT_TRUE(looks_like_rtu(bytes_of("0A 10 00 1E 00 02 04 00 00 75 30 70 8F")));
  EXPECT_TRUE(looks_like_rtu(bytes_of("02 01 04 A1 00 01 AD 2B")));
}

TEST(LooksLikeRtu, RecognisesTheFirstOfSeveral) {
  EXPECT_TRUE(looks_like_rtu(bytes_of("01 03 00 1E 00 02 A4 0D 01 03 00 1E 00 02 A4 0D")));
  EXPECT_TRUE(looks_like_rtu(
      bytes_of("0A 10 00 1E 00 02 04 00 00 75 30 70 8F 01 03 00 1E 00 02 A4 0D 01")));
  EXPECT_TRUE(looks_like_rtu(bytes_of("0A 0F 00 1E 00 02 01 03 77 27 01 03 00 1E 00 02 A4 0D")));
}

TEST(LooksLikeRtu, IsNotFooledByModbusTcpOrShortBytes) {
  EXPECT_FALSE(looks_like_rtu({}));
  EXPECT_FALSE(looks_like_rtu(bytes_of("01 03 00")));
  EXPECT_FALSE(looks_like_rtu(bytes_of("01 7E 80")));  // 7E 80 is the CRC of 01
  EXPECT_FALSE(looks_like_rtu(bytes_of(kRead)));
  EXPECT_FALSE(looks_like_rtu(bytes_of("01 03 00 1E 00 02 A4 0C")));
  EXPECT_FALSE(looks_like_rtu(bytes_of("01 03 00 1E 00 02 A4")));
}

}  // namespace
}  // namespace mbgate::modbus
