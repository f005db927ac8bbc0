// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "modbus/frames.hpp"
#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

// Serial Line V1.02, 6.2.2, step by step: shift right, and XOR with 0xA001 whenever a 1 falls out.
std::uint16_t crc_bit_by_bit(Bytes bytes) {
  unsigned crc = 0xFFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int shift = 0; shift < 8; ++shift) {
      const bool carry = (crc & 1U) != 0;
      crc >>= 1U;
      if (carry) {
        crc ^= 0xA001U;
      }
    }
  }
  return static_cast<std::uint16_t>(crc);
}

TEST(Crc16, OfNothingIsTheInitialValue) { EXPECT_EQ(crc16({}), 0xFFFF); }

TEST(Crc16, OfTheByte02IsThatOfTheFda6000Manual) { EXPECT_EQ(crc16(bytes_of("02")), 0x813E); }

TEST(Crc16, OfTheUsualCheckStringIs4B37) {
  EXPECT_EQ(crc16(bytes_of("31 32 33 34 35 36 37 38 39")), 0x4B37);
}

TEST(Crc16, LowByteIsPrintedFirstInFrames) {
  // The MOONS' manual prints 01 03 00 1E 00 02 with A4 0D behind it.
  EXPECT_EQ(crc16(bytes_of("01 03 00 1E 00 02")), 0x0DA4);
}

TEST(Crc16, AgreesWithTheShiftRegisterForEveryByteAtEveryPlace) {
  for (unsigned value = 0; value < 256; ++value) {
    for (std::size_t place = 0; place < 4; ++place) {
      std::vector<std::uint8_t> bytes = bytes_of("A5 5A 00 FF");
      bytes[place] = static_cast<std::uint8_t>(value);
      ASSERT_EQ(crc16(bytes), crc_bit_by_bit(bytes)) << value << " at " << place;
    }
  }
}

TEST(Crc16, AgreesWithTheShiftRegisterForEveryLengthOfAFrame) {
  std::vector<std::uint8_t> bytes;
  for (unsigned length = 1; length <= 254; ++length) {
    bytes.push_back(static_cast<std::uint8_t>(length * 37U + 11U));
    ASSERT_EQ(crc16(bytes), crc_bit_by_bit(bytes)) << length;
  }
}

TEST(Crc16, SeesEverySingleBitError) {
  const auto good = bytes_of("0A 10 00 1E 00 02 04 00 00 75 30");
  const std::uint16_t crc = crc16(good);
  for (std::size_t bit = 0; bit < good.size() * 8; ++bit) {
    auto bad = good;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    ASSERT_NE(crc16(bad), crc) << "bit " << bit;
  }
}

}  // namespace
}  // namespace mbgate::modbus
