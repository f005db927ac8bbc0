// SPDX-License-Identifier: Apache-2.0
// Frames and times that are printed elsewhere.
#include "world/frames.hpp"

#include <gmock/gmock.h>

#include <string_view>

namespace mbgate::world {
namespace {

using testing::ElementsAreArray;

const Octets kRead{0x03, 0x00, 0x00, 0x00, 0x01};

TEST(Frames, AReadOfOneRegisterInEachFraming) {
  EXPECT_THAT(rtu_frame(1, kRead),
              ElementsAreArray({0x01, 0x03, 0x00, 0x00, 0x00, 0x01, 0x84, 0x0A}));
  constexpr std::string_view kAscii = ":010300000001FB\r\n";
  EXPECT_EQ(ascii_frame(1, kRead), Octets(kAscii.begin(), kAscii.end()));
  EXPECT_THAT(tcp_adu(0x1501, 0xFF, kRead),
              ElementsAreArray({0x15, 0x01, 0, 0, 0, 6, 0xFF, 0x03, 0x00, 0x00, 0x00, 0x01}));
}

TEST(Frames, AWrongCheckIsNoFrame) {
  Octets rtu = rtu_frame(1, kRead);
  Octets ascii = ascii_frame(1, kRead);
  EXPECT_EQ(read_rtu(rtu)->pdu, kRead);
  EXPECT_EQ(read_ascii(ascii)->pdu, kRead);
  rtu[6] ^= 1U;
  ascii[13] = 'E';
  EXPECT_FALSE(read_rtu(rtu));
  EXPECT_FALSE(read_ascii(ascii));
}

TEST(Frames, ElevenBitsACharacter) {
  bus::LineSettings line;
  line.baud = modbus::Baud{9600};
  EXPECT_EQ(WireTimes(line).of(96), 110ms);
  EXPECT_EQ(WireTimes(line).silence(), 4010417ns);
  line.baud = modbus::Baud{115200};
  EXPECT_EQ(WireTimes(line).silence(), 1750us);
}

TEST(Frames, WhatIsCutShortIsNoRequest) {
  EXPECT_TRUE(fields_of(kRead));
  EXPECT_FALSE(fields_of(Octets{0x03, 0x00, 0x00, 0x00}));
  EXPECT_FALSE(fields_of(Octets{0x03, 0x00, 0x00, 0x00, 0x7E}));
  EXPECT_FALSE(fields_of(Octets{0x10, 0x00, 0x00, 0x00, 0x01, 0x02, 0x12}));
  EXPECT_FALSE(fields_of(Octets{0x05, 0x00, 0x00, 0x01, 0x00}));
  const auto fields = fields_of(Octets{0x0F, 0x00, 0x13, 0x00, 0x0A, 0x02, 0xCD, 0x01});
  ASSERT_TRUE(fields);
  EXPECT_THAT(fields->words, ElementsAreArray({1, 0, 1, 1, 0, 0, 1, 1, 1, 0}));
}

}  // namespace
}  // namespace mbgate::world
