// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "modbus/frames.hpp"
#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

using ::testing::ElementsAreArray;

TEST(Rtu, EncodesAddressPduAndCrcLowByteFirst) {
  EXPECT_THAT(encode_rtu(0x0B, pdu_of("06 00 1D 01 2C")),
              ElementsAreArray(bytes_of("0B 06 00 1D 01 2C 19 2B")));
}

TEST(Rtu, DecodesWhatItEncodes) {
  for (const std::size_t data : {0U, 1U, 4U, 251U, 252U}) {
    for (const unsigned address : {0U, 1U, 129U, 247U, 255U}) {
      const Pdu pdu = pdu_of(bytes_of("41", data, 0xC3));
      const RtuBytes frame = encode_rtu(static_cast<std::uint8_t>(address), pdu);
      ASSERT_EQ(frame.size(), data + 1 + kRtuOverhead);
      const auto adu = decode_rtu({frame.data(), frame.size()});
      ASSERT_TRUE(adu.has_value());
      EXPECT_EQ(adu->address, address);
      EXPECT_EQ(adu->pdu, pdu);
    }
  }
}

TEST(Rtu, LongestFrameHas256Bytes) {
  EXPECT_EQ(encode_rtu(1, pdu_of(bytes_of("41", 252, 0))).size(), 256U);
}

TEST(Rtu, RefusesFramesBelow4Bytes) {
  EXPECT_FALSE(decode_rtu({}).has_value());
  EXPECT_FALSE(has_good_crc({}));
  // The CRC of the single byte 02, low byte first: right, but no frame.
  EXPECT_FALSE(has_good_crc(bytes_of("02 3E 81")));
  EXPECT_FALSE(decode_rtu(bytes_of("02 3E 81")).has_value());
}

TEST(Rtu, RefusesFramesAbove256BytesEvenWithAGoodCrc) {
  // Appending the CRC to a frame of 255 bytes makes 257.
  auto frame = bytes_of("01 41", 253, 0x11);
  const std::uint16_t crc = [&] {
    unsigned value = 0xFFFF;
    for (const std::uint8_t byte : frame) {
      value ^= byte;
      for (int shift = 0; shift < 8; ++shift) {
        value = (value & 1U) != 0 ? (value >> 1U) ^ 0xA001U : value >> 1U;
      }
    }
    return static_cast<std::uint16_t>(value);
  }();
  frame.push_back(static_cast<std::uint8_t>(crc & 0xFFU));
  frame.push_back(static_cast<std::uint8_t>(crc >> 8U));
  ASSERT_EQ(frame.size(), 257U);
  ASSERT_TRUE(has_good_crc(frame));
  EXPECT_FALSE(decode_rtu(frame).has_value());
}

TEST(Rtu, RefusesEverySingleBitError) {
  const auto good = bytes_of("01 03 04 00 03 0D 40");
  const RtuBytes frame = encode_rtu(good[0], pdu_of(std::vector(good.begin() + 1, good.end())));
  for (std::size_t bit = 0; bit < frame.size() * 8; ++bit) {
    RtuBytes bad = frame;
    bad[bit / 8] ^= static_cast<std::uint8_t>(1U << (bit % 8));
    EXPECT_FALSE(decode_rtu({bad.data(), bad.size()}).has_value()) << "bit " << bit;
  }
}

TEST(Rtu, RefusesACrcWithItsBytesSwapped) {
  EXPECT_TRUE(decode_rtu(bytes_of("01 03 00 1E 00 02 A4 0D")).has_value());
  EXPECT_FALSE(decode_rtu(bytes_of("01 03 00 1E 00 02 0D A4")).has_value());
}

TEST(Rtu, AddressesAreThoseOfTheSerialLine) {
  EXPECT_EQ(kBroadcastAddress, 0);
  EXPECT_EQ(kMaxDeviceAddress, 247);
}

}  // namespace
}  // namespace mbgate::modbus
