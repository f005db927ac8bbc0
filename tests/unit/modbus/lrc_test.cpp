// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "modbus/frames.hpp"
#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

TEST(Lrc, OfNothingIsZero) { EXPECT_EQ(lrc({}), 0x00); }

// 02 + 03 + 6B + 02 = 72, and 72 + 8E = 100: the FDA6000's printed request (6.1), by hand.
TEST(Lrc, IsWhatIsMissingToAFullByte) { EXPECT_EQ(lrc(bytes_of("02 03 00 6B 00 02")), 0x8E); }

TEST(Lrc, DropsCarries) {
  EXPECT_EQ(lrc(bytes_of("", 0, 0)), 0x00);
  EXPECT_EQ(lrc(bytes_of("FF", 254, 0xFF)), 0xFF);  // 255 times -1
  EXPECT_EQ(lrc(bytes_of("80 80")), 0x00);
}

TEST(Lrc, OfBytesWithTheirLrcIsZero) {
  for (unsigned value = 0; value < 256; ++value) {
    std::vector<std::uint8_t> bytes = bytes_of("01 10 00 1E 7F", 3, 0xC5);
    bytes.push_back(static_cast<std::uint8_t>(value));
    bytes.push_back(lrc(bytes));
    ASSERT_EQ(lrc(bytes), 0x00) << value;
  }
}

}  // namespace
}  // namespace mbgate::modbus
