// SPDX-License-Identifier: Apache-2.0
// Well-formed requests of every function, and what the gateway reads out of them.
#include "modbus/request.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "unit/modbus/bytes_of.hpp"

namespace mbgate::modbus {
namespace {

using ::testing::ElementsAreArray;

Request good(const std::vector<std::uint8_t>& bytes) {
  const auto request = Request::parse(pdu_of(bytes));
  EXPECT_TRUE(request.has_value()) << ::testing::PrintToString(bytes);
  return request.has_value() ? *request : *Request::parse(pdu_of("07"));
}

Request good(std::string_view hex) { return good(bytes_of(hex)); }

void expect_range(const std::optional<AddressField>& field, TableRange range, std::size_t offset) {
  ASSERT_TRUE(field.has_value());
  EXPECT_EQ(field->range, range);
  EXPECT_EQ(field->offset, offset);
}

TEST(Request, ReadsOfTheFourTablesNameTheirRange) {
  expect_range(good("01 00 13 00 25").reads(), {Table::coils, 0x13, 0x25}, 1);
  expect_range(good("02 00 C4 00 16").reads(), {Table::discrete_inputs, 0xC4, 0x16}, 1);
  expect_range(good("03 00 1E 00 02").reads(), {Table::holding_registers, 0x1E, 2}, 1);
  expect_range(good("04 03 E8 00 01").reads(), {Table::input_registers, 0x3E8, 1}, 1);
  EXPECT_FALSE(good("03 00 1E 00 02").writes().has_value());
}

TEST(Request, SingleWritesNameOneRegisterOrCoil) {
  expect_range(good("05 00 0B FF 00").writes(), {Table::coils, 0x0B, 1}, 1);
  expect_range(good("05 00 0B 00 00").writes(), {Table::coils, 0x0B, 1}, 1);
  expect_range(good("06 00 7C 00 E1").writes(), {Table::holding_registers, 0x7C, 1}, 1);
  expect_range(good("16 00 04 00 F2 00 25").writes(), {Table::holding_registers, 4, 1}, 1);
  EXPECT_FALSE(good("06 00 7C 00 E1").reads().has_value());
}

TEST(Request, MultipleWritesNameTheirRange) {
  expect_range(good("0F 00 13 00 0A 02 CD 01").writes(), {Table::coils, 0x13, 10}, 1);
  expect_range(good("10 00 7C 00 02 04 00 DB 00 01").writes(), {Table::holding_registers, 0x7C, 2},
               1);
}

TEST(Request, ReadWriteNamesBothHalves) {
  const Request request = good("17 00 03 00 06 00 0E 00 03 06 00 FF 00 FF 00 FF");
  expect_range(request.reads(), {Table::holding_registers, 3, 6}, 1);
  expect_range(request.writes(), {Table::holding_registers, 0x0E, 3}, 5);
  EXPECT_FALSE(request.is_read());
}

TEST(Request, FifoNamesItsPointerRegister) {
  expect_range(good("18 04 DE").reads(), {Table::holding_registers, 0x4DE, 1}, 1);
}

TEST(Request, FunctionsOfTheSerialLineHaveNoRange) {
  for (const auto* hex : {"07", "0B", "0C", "11", "08 00 00 A5 37", "08 00 00 A5 37 12 34",
                          "14 07 06 00 04 00 01 00 02", "2B 0E 01 00", "2B 0D 00",
                          "15 0D 06 00 04 00 07 00 03 06 AF 04 BE 10 0D"}) {
    const Request request = good(hex);
    EXPECT_FALSE(request.reads().has_value()) << hex;
    EXPECT_FALSE(request.writes().has_value()) << hex;
  }
}

TEST(Request, UnknownFunctionsAreOpaqueAndPass) {
  for (const unsigned function : {9U, 10U, 13U, 14U, 18U, 19U, 25U, 42U, 65U, 70U, 100U, 127U}) {
    for (const std::size_t length : {0U, 1U, 252U}) {
      auto bytes = std::vector<std::uint8_t>(1 + length, 0xA5);
      bytes[0] = static_cast<std::uint8_t>(function);
      const Request request = good(bytes);
      EXPECT_FALSE(request.is_read()) << function;
      EXPECT_THAT(request.pdu().bytes(), ElementsAreArray(bytes));
    }
  }
}

TEST(Request, LimitsOfReadsAreReached) {
  EXPECT_EQ(good("01 00 00 07 D0").reads()->range.count, 2000);
  EXPECT_EQ(good("02 00 00 07 D0").reads()->range.count, 2000);
  EXPECT_EQ(good("03 00 00 00 7D").reads()->range.count, 125);
  EXPECT_EQ(good("04 00 00 00 7D").reads()->range.count, 125);
}

TEST(Request, LimitsOfWritesAreReached) {
  EXPECT_EQ(good(bytes_of("0F 00 00 07 B0 F6", 246, 0xFF)).writes()->range.count, 1968);
  EXPECT_EQ(good(bytes_of("10 00 00 00 7B F6", 246, 0)).writes()->range.count, 123);
  EXPECT_EQ(good(bytes_of("17 00 00 00 7D 00 00 00 79 F2", 242, 0)).writes()->range.count, 121);
}

TEST(Request, LastAddressOfATableCanBeReached) {
  expect_range(good("03 FF FF 00 01").reads(), {Table::holding_registers, 0xFFFF, 1}, 1);
  expect_range(good("01 F8 30 07 D0").reads(), {Table::coils, 0xF830, 2000}, 1);
  expect_range(good("06 FF FF 00 00").writes(), {Table::holding_registers, 0xFFFF, 1}, 1);
  expect_range(good("10 FF FE 00 02 04 00 00 00 00").writes(),
               {Table::holding_registers, 0xFFFE, 2}, 1);
}

TEST(Request, MovesToOtherAddresses) {
  const Request read = good("03 00 1E 00 02").with_addresses(0x0164, 0x9999);
  EXPECT_THAT(read.pdu().bytes(), ElementsAreArray(bytes_of("03 01 64 00 02")));
  expect_range(read.reads(), {Table::holding_registers, 0x0164, 2}, 1);
  EXPECT_FALSE(read.writes().has_value());

  const Request both =
      good("17 00 03 00 01 00 0E 00 01 02 00 FF").with_addresses(0x0103, std::nullopt);
  EXPECT_THAT(both.pdu().bytes(),
              ElementsAreArray(bytes_of("17 01 03 00 01 00 0E 00 01 02 00 FF")));
  EXPECT_THAT(both.with_addresses(std::nullopt, 0x020E).pdu().bytes(),
              ElementsAreArray(bytes_of("17 01 03 00 01 02 0E 00 01 02 00 FF")));
}

TEST(Request, EchoOfAWriteIsItsNormalResponse) {
  const auto echo = [](std::string_view hex) {
    const Pdu pdu = echo_response(good(hex));
    return std::vector<std::uint8_t>(pdu.bytes().begin(), pdu.bytes().end());
  };
  EXPECT_EQ(echo("05 00 0B FF 00"), bytes_of("05 00 0B FF 00"));
  EXPECT_EQ(echo("06 00 7C 00 E1"), bytes_of("06 00 7C 00 E1"));
  EXPECT_EQ(echo("0F 00 13 00 0A 02 CD 01"), bytes_of("0F 00 13 00 0A"));
  EXPECT_EQ(echo("10 00 7C 00 02 04 00 DB 00 01"), bytes_of("10 00 7C 00 02"));
  EXPECT_EQ(echo("16 00 04 00 F2 00 25"), bytes_of("16 00 04 00 F2 00 25"));
}

}  // namespace
}  // namespace mbgate::modbus
