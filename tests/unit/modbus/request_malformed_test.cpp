// SPDX-License-Identifier: Apache-2.0
// Every way in which a request can be malformed, and which exception code it earns.
#include <gtest/gtest.h>

#include "modbus/request.hpp"
#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

using enum ExceptionCode;

/// The error of parse(), or nothing where the request is accepted.
std::optional<ExceptionCode> error_of(const std::vector<std::uint8_t>& bytes) {
  const auto request = Request::parse(pdu_of(bytes));
  return request.has_value() ? std::nullopt : std::optional(request.error());
}

std::optional<ExceptionCode> error_of(std::string_view hex) { return error_of(bytes_of(hex)); }

TEST(RequestMalformed, Functions0And128To255AreNotAllowed) {
  EXPECT_EQ(error_of("00"), illegal_function);
  EXPECT_EQ(error_of("00 00 1E 00 02"), illegal_function);
  for (unsigned function = 128; function <= 255; ++function) {
    const std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(function), 0, 0, 0, 1};
    EXPECT_EQ(error_of(bytes), illegal_function) << function;
  }
}

// Each function cut short at every length and with one byte too many.
TEST(RequestMalformed, LengthsThatDoNotFitTheFunctionAreRefused) {
  for (const auto* hex :
       {"01 00 13 00 25", "02 00 C4 00 16", "03 00 1E 00 02", "04 00 08 00 01", "05 00 AC FF 00",
        "06 00 01 00 03", "0F 00 13 00 0A 02 CD 01", "10 00 01 00 02 04 00 0A 01 02",
        "16 00 04 00 F2 00 25", "17 00 03 00 06 00 0E 00 03 06 00 FF 00 FF 00 FF", "18 04 DE",
        "14 07 06 00 04 00 01 00 02", "15 0D 06 00 04 00 07 00 03 06 AF 04 BE 10 0D",
        "2B 0E 01 00"}) {
    const auto whole = bytes_of(hex);
    EXPECT_EQ(error_of(whole), std::nullopt) << hex;
    for (std::size_t length = 1; length < whole.size(); ++length) {
      const auto cut =
          std::vector<std::uint8_t>(whole.begin(), whole.begin() + std::ptrdiff_t(length));
      EXPECT_EQ(error_of(cut), illegal_data_value) << hex << " cut to " << length;
    }
    auto longer = whole;
    longer.push_back(0);
    EXPECT_EQ(error_of(longer), illegal_data_value) << hex << " and one more";
  }
}

TEST(RequestMalformed, FileRecordsAreWholeAndOfType6) {
  for (const auto* hex :
       {"14 07 05 00 04 00 01 00 02", "14 0E 06 00 04 00 01 00 02 07 00 04 00 01 00 02",
        "15 0D 06 00 04 00 07 00 09 06 AF 04 BE 10 0D", "15 09 07 00 04 00 07 00 01 06 AF",
        "15 0B 06 00 04 00 07 00 01 06 AF 04 BE"}) {
    EXPECT_EQ(error_of(hex), illegal_data_value) << hex;
  }
  EXPECT_EQ(error_of("14 0E 06 00 04 00 01 00 02 06 00 04 00 01 00 02"), std::nullopt);
  EXPECT_EQ(error_of("15 12 06 00 04 00 07 00 01 06 AF 06 00 05 00 07 00 01 04 BE"), std::nullopt);
}

TEST(RequestMalformed, FunctionsWithoutDataTakeNone) {
  for (const auto* hex : {"07 00", "0B 00", "0C 00", "11 00"}) {
    EXPECT_EQ(error_of(hex), illegal_data_value) << hex;
  }
}

TEST(RequestMalformed, DiagnosticsNeedASubFunctionAndWholeWords) {
  for (const auto* hex : {"08", "08 00", "08 00 00", "08 00 00 A5", "08 00 00 A5 37 12"}) {
    EXPECT_EQ(error_of(hex), illegal_data_value) << hex;
  }
}

TEST(RequestMalformed, Quantity0IsRefused) {
  for (const auto* hex : {"01 00 00 00 00", "02 00 00 00 00", "03 00 00 00 00", "04 00 00 00 00",
                          "0F 00 00 00 00 00", "10 00 00 00 00 00",
                          "17 00 00 00 00 00 00 00 01 02 00 00", "17 00 00 00 01 00 00 00 00 00"}) {
    EXPECT_EQ(error_of(hex), illegal_data_value) << hex;
  }
}

TEST(RequestMalformed, QuantityOverTheLimitIsRefused) {
  EXPECT_EQ(error_of("01 00 00 07 D1"), illegal_data_value);
  EXPECT_EQ(error_of("02 00 00 07 D1"), illegal_data_value);
  EXPECT_EQ(error_of("03 00 00 00 7E"), illegal_data_value);
  EXPECT_EQ(error_of("04 00 00 00 7E"), illegal_data_value);
  EXPECT_EQ(error_of("03 00 00 FF FF"), illegal_data_value);
  EXPECT_EQ(error_of("17 00 00 00 7E 00 00 00 01 02 00 00"), illegal_data_value);
  // 1969 to 1976 bits fit into the 247 bytes that a PDU can hold after the byte count.
  EXPECT_EQ(error_of(bytes_of("0F 00 00 07 B1 F7", 247, 0)), illegal_data_value);
}

TEST(RequestMalformed, ByteCountThatLiesIsRefused) {
  EXPECT_EQ(error_of("0F 00 13 00 0A 01 CD 01"), illegal_data_value);
  EXPECT_EQ(error_of("0F 00 13 00 0A 03 CD 01"), illegal_data_value);
  EXPECT_EQ(error_of("0F 00 13 00 0A 03 CD 01 00"), illegal_data_value);
  EXPECT_EQ(error_of("0F 00 13 00 0A 01 CD"), illegal_data_value);
  EXPECT_EQ(error_of("10 00 01 00 02 02 00 0A 01 02"), illegal_data_value);
  EXPECT_EQ(error_of("10 00 01 00 02 02 00 0A"), illegal_data_value);
  EXPECT_EQ(error_of("10 00 01 00 02 06 00 0A 01 02 00 00"), illegal_data_value);
  EXPECT_EQ(error_of("17 00 03 00 06 00 0E 00 03 04 00 FF 00 FF"), illegal_data_value);
  EXPECT_EQ(error_of("14 08 06 00 04 00 01 00 02"), illegal_data_value);
  // 256 registers make 512 bytes, whose low byte is the 0 in the byte count.
  EXPECT_EQ(error_of("10 00 00 01 00 00"), illegal_data_value);
  EXPECT_EQ(error_of("17 00 00 00 01 00 00 00 80 00"), illegal_data_value);
}

TEST(RequestMalformed, CoilValuesAre0000AndFF00Only) {
  for (const auto* hex : {"05 00 AC 00 01", "05 00 AC FF FF", "05 00 AC 01 00", "05 00 AC 00 FF"}) {
    EXPECT_EQ(error_of(hex), illegal_data_value) << hex;
  }
}

TEST(RequestMalformed, AddressPlusQuantityBeyond65536IsAnIllegalAddress) {
  EXPECT_EQ(error_of("01 F8 31 07 D0"), illegal_data_address);
  EXPECT_EQ(error_of("02 FF FF 00 02"), illegal_data_address);
  EXPECT_EQ(error_of("03 FF FF 00 02"), illegal_data_address);
  EXPECT_EQ(error_of("04 FF 84 00 7D"), illegal_data_address);
  EXPECT_EQ(error_of("0F FF FF 00 02 01 03"), illegal_data_address);
  EXPECT_EQ(error_of("10 FF FF 00 02 04 00 00 00 00"), illegal_data_address);
  EXPECT_EQ(error_of("17 FF FF 00 02 00 00 00 01 02 00 00"), illegal_data_address);
  EXPECT_EQ(error_of("17 00 00 00 01 FF FF 00 02 04 00 00 00 00"), illegal_data_address);
}

// Quantities are looked at before addresses (Application Protocol V1.1b3, figures 11 to 29).
TEST(RequestMalformed, WrongQuantityComesBeforeWrongAddress) {
  EXPECT_EQ(error_of("03 FF FF 00 7E"), illegal_data_value);
  EXPECT_EQ(error_of("10 FF FF 00 02 02 00 00 00 00"), illegal_data_value);
  EXPECT_EQ(error_of("17 FF FF 00 02 00 00 00 00 00"), illegal_data_value);
}

// 6.14: sub-requests of 7 bytes, byte count 0x07 to 0xF5.
TEST(RequestMalformed, FileRecordReadsAreWholeSubRequestsUpTo245Bytes) {
  EXPECT_EQ(error_of(bytes_of("14 F5", 245, 6)), std::nullopt);
  EXPECT_EQ(error_of(bytes_of("14 08", 8, 6)), illegal_data_value);
  EXPECT_EQ(error_of(bytes_of("14 F6", 246, 6)), illegal_data_value);
}

}  // namespace
}  // namespace mbgate::modbus
