// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <algorithm>
#include <array>

#include "modbus/codes.hpp"
#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

TEST(FunctionCode, RequestsAre1To127) {
  EXPECT_FALSE(is_request_function(0));
  for (unsigned function = 1; function <= 127; ++function) {
    EXPECT_TRUE(is_request_function(static_cast<std::uint8_t>(function))) << function;
  }
  for (unsigned function = 128; function <= 255; ++function) {
    EXPECT_FALSE(is_request_function(static_cast<std::uint8_t>(function))) << function;
  }
}

TEST(FunctionCode, ReadsAreThoseOfTheContractAndNothingElse) {
  constexpr std::array<unsigned, 10> kReads{1, 2, 3, 4, 7, 11, 12, 17, 20, 24};
  for (unsigned function = 0; function < 256; ++function) {
    const std::array<std::uint8_t, 1> pdu{static_cast<std::uint8_t>(function)};
    EXPECT_EQ(is_read(pdu), std::ranges::count(kReads, function) == 1) << function;
  }
}

TEST(FunctionCode, EncapsulatedInterfaceReadsOnlyAsDeviceIdentification) {
  EXPECT_TRUE(is_read(bytes_of("2B 0E 01 00")));
  EXPECT_FALSE(is_read(bytes_of("2B 0D 01 00")));  // CANopen general reference
  EXPECT_FALSE(is_read(bytes_of("2B")));
}

TEST(FunctionCode, NamesAreThoseOfTheStandard) {
  EXPECT_EQ(function_name(0x03), "read holding registers");
  EXPECT_EQ(function_name(0x10), "write multiple registers");
  EXPECT_EQ(function_name(0x17), "read/write multiple registers");
  EXPECT_EQ(function_name(0x2B), "encapsulated interface");
  EXPECT_EQ(function_name(0x46), "");  // user-defined: the FDA6000's JOG
  EXPECT_EQ(function_name(0x83), "");
}

TEST(ExceptionCode, TextNamesTheStandardCodes) {
  EXPECT_EQ(exception_text(0x01), "exception 0x01 (illegal function)");
  EXPECT_EQ(exception_text(0x02), "exception 0x02 (illegal data address)");
  EXPECT_EQ(exception_text(0x03), "exception 0x03 (illegal data value)");
  EXPECT_EQ(exception_text(0x04), "exception 0x04 (server device failure)");
  EXPECT_EQ(exception_text(0x05), "exception 0x05 (acknowledge)");
  EXPECT_EQ(exception_text(0x06), "exception 0x06 (server device busy)");
  EXPECT_EQ(exception_text(0x08), "exception 0x08 (memory parity error)");
  EXPECT_EQ(exception_text(0x0A), "exception 0x0A (gateway path unavailable)");
  EXPECT_EQ(exception_text(0x0B), "exception 0x0B (gateway target device failed to respond)");
}

TEST(ExceptionCode, TextOfVendorCodesIsTheNumber) {
  EXPECT_EQ(exception_text(0x11), "exception 0x11");  // MOONS': not readable
  EXPECT_EQ(exception_text(0x07), "exception 0x07");  // FDA6000: NAK
  EXPECT_EQ(exception_text(0xFF), "exception 0xFF");
}

}  // namespace
}  // namespace mbgate::modbus
