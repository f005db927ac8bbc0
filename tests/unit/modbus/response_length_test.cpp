// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "modbus/response.hpp"
#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

using Kind = PduLength::Kind;

void expect_known(const std::vector<std::uint8_t>& prefix, std::size_t bytes) {
  const PduLength length = response_length(prefix);
  EXPECT_EQ(length.kind, Kind::known) << ::testing::PrintToString(prefix);
  EXPECT_EQ(length.bytes, bytes) << ::testing::PrintToString(prefix);
}

void expect_known(std::string_view hex, std::size_t bytes) { expect_known(bytes_of(hex), bytes); }

Kind kind_of(std::string_view hex) { return response_length(bytes_of(hex)).kind; }

PduLength expected(std::string_view hex) {
  return expected_response_length(*Request::parse(pdu_of(hex)));
}

TEST(ResponseLength, ByteCountsDecideWhereThereIsOne) {
  for (const unsigned function : {0x01U, 0x02U, 0x03U, 0x04U, 0x0CU, 0x11U, 0x14U, 0x15U, 0x17U}) {
    const auto code = static_cast<std::uint8_t>(function);
    const std::vector<std::uint8_t> only_function{code};
    EXPECT_EQ(response_length(only_function).kind, Kind::need_more) << function;
    for (const unsigned count : {0U, 1U, 2U, 250U, 251U, 255U}) {
      expect_known({code, static_cast<std::uint8_t>(count)}, 2 + count);
    }
  }
}

TEST(ResponseLength, FixedResponsesAreKnownFromTheFunctionAlone) {
  expect_known("05", 5);
  expect_known("06", 5);
  expect_known("07", 2);
  expect_known("0B", 5);
  expect_known("0F", 5);
  expect_known("10", 5);
  expect_known("16", 7);
}

TEST(ResponseLength, ExceptionsHaveTwoBytes) {
  for (unsigned function = 128; function <= 255; ++function) {
    expect_known(std::vector<std::uint8_t>{static_cast<std::uint8_t>(function)}, 2);
  }
}

TEST(ResponseLength, FifoHasASixteenBitByteCount) {
  EXPECT_EQ(kind_of("18"), Kind::need_more);
  EXPECT_EQ(kind_of("18 00"), Kind::need_more);
  expect_known("18 00 06", 9);
  expect_known("18 00 40", 67);  // 31 registers, the most (6.18)
  expect_known("18 01 00", 259);
}

TEST(ResponseLength, DeviceIdentificationIsKnownOnceTheLastObjectHasBegun) {
  // Three objects of 2, 0 and 4 bytes.
  const auto whole = bytes_of("2B 0E 01 01 00 00 03 00 02 41 42 01 00 02 04 56 31 2E 30");
  for (std::size_t size = 1; size < whole.size(); ++size) {
    const auto prefix =
        std::vector<std::uint8_t>(whole.begin(), whole.begin() + std::ptrdiff_t(size));
    const PduLength length = response_length(prefix);
    if (size < 15) {  // the length byte of the third object is the fifteenth
      EXPECT_EQ(length.kind, Kind::need_more) << size;
    } else {
      EXPECT_EQ(length.kind, Kind::known) << size;
      EXPECT_EQ(length.bytes, whole.size()) << size;
    }
  }
}

TEST(ResponseLength, DeviceIdentificationWithoutObjectsEndsAfterItsFields) {
  expect_known("2B 0E 01 01 00 00 00", 7);
}

TEST(ResponseLength, WhatNobodySpecifiedIsOpaque) {
  for (const auto* hex : {"08", "08 00 00 A5 37", "09", "41", "46", "64", "7F", "2B 0D"}) {
    EXPECT_EQ(kind_of(hex), Kind::opaque) << hex;
  }
  EXPECT_EQ(kind_of("2B"), Kind::need_more);
}

TEST(ExpectedResponseLength, FollowsFromTheQuantity) {
  EXPECT_EQ(expected("01 00 00 00 01").bytes, 3U);
  EXPECT_EQ(expected("01 00 00 00 08").bytes, 3U);
  EXPECT_EQ(expected("02 00 00 00 09").bytes, 4U);
  EXPECT_EQ(expected("01 00 00 07 D0").bytes, 252U);
  EXPECT_EQ(expected("03 00 00 00 01").bytes, 4U);
  EXPECT_EQ(expected("04 00 00 00 7D").bytes, 252U);
  EXPECT_EQ(expected("17 00 00 00 02 00 00 00 01 02 00 00").bytes, 6U);
}

TEST(ExpectedResponseLength, OfWritesIsThatOfTheirEcho) {
  for (const auto* hex : {"05 00 0B FF 00", "06 00 7C 00 E1", "0F 00 13 00 0A 02 CD 01",
                          "10 00 7C 00 02 04 00 DB 00 01"}) {
    EXPECT_EQ(expected(hex).kind, Kind::known) << hex;
    EXPECT_EQ(expected(hex).bytes, 5U) << hex;
  }
  EXPECT_EQ(expected("16 00 04 00 F2 00 25").bytes, 7U);
  EXPECT_EQ(expected("15 09 06 00 04 00 07 00 01 06 AF").bytes, 11U);
  EXPECT_EQ(expected("08 00 00 A5 37").bytes, 5U);
  EXPECT_EQ(expected("07").bytes, 2U);
  EXPECT_EQ(expected("0B").bytes, 5U);
}

TEST(ExpectedResponseLength, IsOpenWhereTheDeviceDecides) {
  for (const auto* hex : {"0C", "11", "14 07 06 00 04 00 01 00 02", "18 04 DE", "2B 0E 01 00"}) {
    EXPECT_EQ(expected(hex).kind, Kind::need_more) << hex;
  }
  for (const auto* hex : {"41", "46 01", "2B 0D 00"}) {
    EXPECT_EQ(expected(hex).kind, Kind::opaque) << hex;
  }
}

}  // namespace
}  // namespace mbgate::modbus
