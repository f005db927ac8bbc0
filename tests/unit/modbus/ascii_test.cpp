// SPDX-License-Identifier: Apache-2.0
// The FDA6000's manual describes ASCII frames (2.2) and prints its examples in RTU (section 6): the
// same addresses and PDUs in ASCII, LRCs added up by hand.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "manuals/vectors.hpp"
#include "modbus/frames.hpp"
#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

using ::testing::ElementsAreArray;

std::vector<std::uint8_t> characters(std::string_view text) { return {text.begin(), text.end()}; }

std::string text_of(const AsciiBytes& frame) { return {frame.begin(), frame.end()}; }

bool is_good(std::string_view text) { return decode_ascii(characters(text)).has_value(); }

TEST(Ascii, EncodesInCapitalsBetweenColonAndLineEnd) {
  EXPECT_EQ(text_of(encode_ascii(0x02, pdu_of("03 00 6B 00 02"))), ":0203006B00028E\r\n");
  EXPECT_EQ(text_of(encode_ascii(0x02, pdu_of("03 04 02 2B 00 00"))),
            ":0203040"
            "22B0000CA\r\n");
  EXPECT_EQ(text_of(encode_ascii(0x02, pdu_of("06 00 01 00 03"))), ":020600010003F4\r\n");
  EXPECT_EQ(text_of(encode_ascii(0x02, pdu_of("81 02"))), ":0281027B\r\n");
}

TEST(Ascii, DecodesWhatItEncodes) {
  for (const std::size_t data : {0U, 1U, 4U, 251U, 252U}) {
    for (const unsigned address : {0U, 1U, 129U, 247U, 255U}) {
      const Pdu pdu = pdu_of(bytes_of("41", data, 0xC3));
      const AsciiBytes frame = encode_ascii(static_cast<std::uint8_t>(address), pdu);
      ASSERT_EQ(frame.size(), 2 * (data + 3) + kAsciiFraming);
      const auto adu = decode_ascii({frame.data(), frame.size()});
      ASSERT_TRUE(adu.has_value());
      EXPECT_EQ(adu->address, address);
      EXPECT_EQ(adu->pdu, pdu);
    }
  }
}

TEST(Ascii, CarriesEveryPrintedFrameUnchanged) {
  for (const auto& frame : manuals::load_rtu()) {
    const auto adu = decode_rtu(frame.bytes);
    ASSERT_TRUE(adu) << frame.where();
    const AsciiBytes ascii = encode_ascii(adu->address, adu->pdu);
    const auto back = decode_ascii({ascii.data(), ascii.size()});
    ASSERT_TRUE(back) << frame.where();
    EXPECT_EQ(back->address, adu->address) << frame.where();
    EXPECT_EQ(back->pdu, adu->pdu) << frame.where();
  }
}

TEST(Ascii, LongestFrameHas513Characters) {
  EXPECT_EQ(encode_ascii(1, pdu_of(bytes_of("41", 252, 0))).size(), 513U);
  EXPECT_EQ(kMaxAsciiSize, 513U);
}

TEST(Ascii, UnderstandsSmallLettersToo) {
  EXPECT_TRUE(is_good(":0203006b00028e\r\n"));
  EXPECT_TRUE(is_good(":0203006B00028e\r\n"));
}

TEST(Ascii, RefusesWhatIsNotFramed) {
  EXPECT_TRUE(is_good(":0203006B00028E\r\n"));
  EXPECT_FALSE(is_good(""));
  EXPECT_FALSE(is_good("0203006B00028E\r\n"));
  EXPECT_FALSE(is_good(":0203006B00028E"));
  EXPECT_FALSE(is_good(":0203006B00028E\n"));
  EXPECT_FALSE(is_good(":0203006B00028E\n\r"));
  EXPECT_FALSE(is_good(":0203006B00028E\r\n\r\n"));
  EXPECT_FALSE(is_good("::0203006B00028E\r\n"));
}

TEST(Ascii, RefusesWhatIsNotHexadecimal) {
  EXPECT_FALSE(is_good(":0203006B0002 8E\r\n"));
  EXPECT_FALSE(is_good(":0203006G00028E\r\n"));
  EXPECT_FALSE(is_good(":02:3006B00028E\r\n"));
  EXPECT_FALSE(is_good(":0203006B00028\r\n"));  // half a byte is missing
  EXPECT_FALSE(
      is_good(":0203006B0002\xB8"
              "E\r\n"));  // the eighth bit
}

TEST(Ascii, RefusesAWrongLrcButGivesTheContent) {
  const auto frame = characters(":0203006B00028F\r\n");
  EXPECT_FALSE(decode_ascii(frame).has_value());
  const auto content = ascii_content(frame);
  ASSERT_TRUE(content.has_value());
  EXPECT_THAT(*content, ElementsAreArray(bytes_of("02 03 00 6B 00 02 8F")));
  EXPECT_FALSE(has_good_lrc({content->data(), content->size()}));
}

TEST(Ascii, RefusesContentBelow3BytesAndAbove255) {
  EXPECT_FALSE(is_good(":\r\n"));
  EXPECT_FALSE(is_good(":02FE\r\n"));
  EXPECT_TRUE(is_good(":0207F7\r\n"));
  EXPECT_FALSE(has_good_lrc(bytes_of("02 FE")));
  const std::string zeros(508, '0');  // 254 bytes
  EXPECT_TRUE(is_good(":01" + zeros.substr(2) + "FF\r\n"));
  EXPECT_FALSE(is_good(":01" + zeros + "FF\r\n"));
}

TEST(Ascii, SeesEverySingleWrongCharacter) {
  const std::string good = ":0203006B00028E\r\n";
  for (std::size_t at = 0; at < good.size(); ++at) {
    for (const char other : {'1', '5', 'D', 'x', ':', '\n'}) {
      std::string bad = good;
      bad[at] = other;
      EXPECT_EQ(is_good(bad), bad == good) << at << other;
    }
  }
}

}  // namespace
}  // namespace mbgate::modbus
