// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/value.hpp"

#include <gtest/gtest.h>

#include <array>

namespace mbgate::ctl {
namespace {

using drive::WordOrder;

/// The error of a text that must not be understood.
std::string error_of(ValueType type, std::string_view text) {
  const auto value = parse_value(type, text);
  return value ? "no error" : value.error();
}

TEST(Value, IsReadInDecimal) {
  EXPECT_EQ(*parse_value(ValueType::u16, "65535"), 0xFFFFU);
  EXPECT_EQ(*parse_value(ValueType::i16, "-2"), 0xFFFEU);
  EXPECT_EQ(*parse_value(ValueType::u32, "4294967295"), 0xFFFFFFFFU);
  EXPECT_EQ(*parse_value(ValueType::i32, "200000"), 0x00030D40U);
  EXPECT_EQ(*parse_value(ValueType::i32, "-2147483648"), 0x80000000U);
}

TEST(Value, IsReadInHexAsItsBits) {
  EXPECT_EQ(*parse_value(ValueType::u16, "0xD8"), 0x00D8U);
  EXPECT_EQ(*parse_value(ValueType::i16, "0XfffE"), 0xFFFEU);
  EXPECT_EQ(*parse_value(ValueType::i32, "0xFFFFFFFB"), 0xFFFFFFFBU);
  EXPECT_EQ(*parse_value(ValueType::f32, "0x3FC00000"), 0x3FC00000U);
}

TEST(Value, IsReadAsAFloat) {
  EXPECT_EQ(*parse_value(ValueType::f32, "1.5"), 0x3FC00000U);
  EXPECT_EQ(*parse_value(ValueType::f32, "-2e3"), 0xC4FA0000U);
  EXPECT_EQ(*parse_value(ValueType::f32, "7"), 0x40E00000U);
}

TEST(Value, IsReadAsABit) {
  for (const auto* text : {"1", "on"}) {
    EXPECT_EQ(*parse_value(ValueType::bit, text), 1U) << text;
  }
  for (const auto* text : {"0", "off"}) {
    EXPECT_EQ(*parse_value(ValueType::bit, text), 0U) << text;
  }
}

TEST(Value, OutsideItsTypeIsRefused) {
  EXPECT_EQ(error_of(ValueType::u16, "65536"), "\"65536\" is outside u16, 0 to 65535");
  EXPECT_EQ(error_of(ValueType::u16, "-1"), "\"-1\" is outside u16, 0 to 65535");
  EXPECT_EQ(error_of(ValueType::i16, "32768"), "\"32768\" is outside i16, -32768 to 32767");
  EXPECT_EQ(error_of(ValueType::i32, "2147483648"),
            "\"2147483648\" is outside i32, -2147483648 to 2147483647");
  EXPECT_EQ(error_of(ValueType::u32, "4294967296"),
            "\"4294967296\" is outside u32, 0 to 4294967295");
  EXPECT_EQ(error_of(ValueType::u16, "0x10000"), "\"0x10000\" has more than 16 bits");
  EXPECT_EQ(error_of(ValueType::i32, "0x100000000"), "\"0x100000000\" has more than 32 bits");
  EXPECT_EQ(error_of(ValueType::bit, "2"), "\"2\" is not a bit: 0, 1, off or on");
}

TEST(Value, ThatIsNoneIsRefused) {
  for (const auto* text : {"", "abc", "1x", " 1", "1.5", "+1", "--1", "99999999999999999999"}) {
    EXPECT_EQ(error_of(ValueType::i32, text),
              "\"" + std::string(text) + "\" is not a whole number");
  }
  for (const auto* text : {"0x", "0xG", "0x-1"}) {
    EXPECT_EQ(error_of(ValueType::u16, text),
              "\"" + std::string(text) + "\" is not a hexadecimal number");
  }
  for (const auto* text : {"", "nan", "inf", "1e99", "1,5"}) {
    EXPECT_EQ(error_of(ValueType::f32, text),
              "\"" + std::string(text) + "\" is not a number that f32 can hold");
  }
}

TEST(Address, IsDecimalOrHex) {
  EXPECT_EQ(*parse_address("30"), 30);
  EXPECT_EQ(*parse_address("0x1E"), 30);
  EXPECT_EQ(*parse_address("0xFFFF"), 65535);
  for (const auto* text : {"65536", "-1", "0x10000", "1E", ""}) {
    EXPECT_EQ(parse_address(text).error(),
              "\"" + std::string(text) + "\" is not an address, 0 to 65535 or 0x0 to 0xFFFF");
  }
}

TEST(Value, IsPrintedForPeople) {
  EXPECT_EQ(value_line(30, ValueType::i32, 0x00030D40), "30: 200000 (0x00030D40)");
  EXPECT_EQ(value_line(65535, ValueType::i16, 0xFFFB), "65535: -5 (0xFFFB)");
  EXPECT_EQ(value_line(0, ValueType::u32, 0xFFFFFFFB), "0: 4294967291 (0xFFFFFFFB)");
  EXPECT_EQ(value_line(1, ValueType::f32, 0x3FC00000), "1: 1.5 (0x3FC00000)");
  EXPECT_EQ(value_line(11, ValueType::bit, 1), "11: 1 (on)");
  EXPECT_EQ(value_line(11, ValueType::bit, 0), "11: 0 (off)");
}

TEST(Value, IsPrintedAsItIsRead) {
  for (const auto* text : {"0", "-1", "2147483647", "-2147483648"}) {
    EXPECT_EQ(value_text(ValueType::i32, *parse_value(ValueType::i32, text)), text);
  }
  EXPECT_EQ(value_text(ValueType::f32, *parse_value(ValueType::f32, "-0.1")), "-0.1");
}

TEST(Value, TakesItsRegistersInEitherOrder) {
  const std::array<std::uint32_t, 2> values{0x00030D40, 0xFFFFFFFB};
  const std::vector<std::uint16_t> big{0x0003, 0x0D40, 0xFFFF, 0xFFFB};
  const std::vector<std::uint16_t> little{0x0D40, 0x0003, 0xFFFB, 0xFFFF};
  EXPECT_EQ(to_registers(ValueType::i32, WordOrder::big, values), big);
  EXPECT_EQ(to_registers(ValueType::i32, WordOrder::little, values), little);
  EXPECT_EQ(to_values(ValueType::i32, WordOrder::big, big),
            std::vector(values.begin(), values.end()));
  EXPECT_EQ(to_values(ValueType::i32, WordOrder::little, little),
            std::vector(values.begin(), values.end()));
}

TEST(Value, OfOneRegisterKnowsNoOrder) {
  const std::vector<std::uint32_t> values{1, 0xFFFE};
  const std::vector<std::uint16_t> registers{1, 0xFFFE};
  for (const auto order : {WordOrder::big, WordOrder::little}) {
    EXPECT_EQ(to_registers(ValueType::u16, order, values), registers);
    EXPECT_EQ(to_values(ValueType::u16, order, registers), values);
  }
}

}  // namespace
}  // namespace mbgate::ctl
