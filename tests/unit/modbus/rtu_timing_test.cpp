// SPDX-License-Identifier: Apache-2.0
#include "modbus/rtu_timing.hpp"

#include <gtest/gtest.h>

namespace mbgate::modbus {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;
using std::chrono::nanoseconds;

constexpr CharacterFormat k8E1{8, Parity::even, 1};
constexpr CharacterFormat k8N1{8, Parity::none, 1};
constexpr CharacterFormat k8N2{8, Parity::none, 2};

RtuTiming at(std::uint32_t baud, CharacterFormat format = k8E1) { return {Baud{baud}, format}; }

TEST(CharacterFormat, StandardCharactersHave11Bits) {
  EXPECT_EQ(CharacterFormat{}, k8E1);
  EXPECT_EQ(k8E1.bits(), 11U);
  EXPECT_EQ(k8N2.bits(), 11U);
  EXPECT_EQ((CharacterFormat{8, Parity::odd, 1}.bits()), 11U);
  EXPECT_EQ(k8N1.bits(), 10U);
  EXPECT_EQ((CharacterFormat{7, Parity::even, 1}.bits()), 10U);  // ASCII
  EXPECT_EQ((CharacterFormat{8, Parity::even, 2}.bits()), 12U);
}

// 3.5 characters of 11 bits are 38.5 bits; never rounded down.
TEST(RtuTiming, SilenceIs3AndAHalfCharactersUpTo19200) {
  EXPECT_EQ(at(9600).t3_5(), nanoseconds(4'010'417));
  EXPECT_EQ(at(19200).t3_5(), nanoseconds(2'005'209));
  EXPECT_EQ(at(1200).t3_5(), nanoseconds(32'083'334));
  EXPECT_EQ(at(300).t3_5(), nanoseconds(128'333'334));
  EXPECT_EQ(at(9600, k8N1).t3_5(), nanoseconds(3'645'834));
}

TEST(RtuTiming, SilenceIsFixedAbove19200) {
  for (const std::uint32_t baud : {19201U, 38400U, 57600U, 115200U, 921600U, 4'000'000U}) {
    EXPECT_EQ(at(baud).t3_5(), microseconds(1750)) << baud;
    EXPECT_EQ(at(baud, k8N1).t3_5(), microseconds(1750)) << baud;
  }
}

TEST(RtuTiming, BytesTakeTheirBits) {
  EXPECT_EQ(at(9600).duration_of(0), nanoseconds(0));
  EXPECT_EQ(at(9600).duration_of(1), nanoseconds(1'145'834));  // 11 bits
  EXPECT_EQ(at(9600).duration_of(8), nanoseconds(9'166'667));  // 88 bits
  EXPECT_EQ(at(10000).duration_of(10), milliseconds(11));
  EXPECT_EQ(at(115200).duration_of(8), nanoseconds(763'889));
  EXPECT_EQ(at(115200, k8N1).duration_of(256), nanoseconds(22'222'223));
  EXPECT_EQ(at(300).duration_of(256), nanoseconds(9'386'666'667));
}

TEST(RtuTiming, LowestAndHighestRatesStayExact) {
  EXPECT_EQ(at(1).duration_of(256), std::chrono::seconds(2816));
  EXPECT_EQ(at(1'000'000).duration_of(1), microseconds(11));
}

}  // namespace
}  // namespace mbgate::modbus
