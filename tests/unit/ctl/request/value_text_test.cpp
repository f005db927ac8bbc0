// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/value_text.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <limits>

namespace mbgate::ctl {
namespace {

/// The bits of one value.
Result<std::uint64_t, std::string> parse_value(ValueType type, const std::string& text) {
  const auto values = parse_values(type, {&text, 1});
  if (!values) {
    return values.error();
  }
  return values->front();
}

/// The error of a text that must not be understood.
std::string error_of(ValueType type, const std::string& text) {
  const auto value = parse_value(type, text);
  return value ? "no error" : value.error();
}

TEST(Value, IsReadInDecimal) {
  EXPECT_EQ(*parse_value(ValueType::u16, "65535"), 0xFFFFU);
  EXPECT_EQ(*parse_value(ValueType::i16, "-2"), 0xFFFEU);
  EXPECT_EQ(*parse_value(ValueType::u32, "4294967295"), 0xFFFFFFFFU);
  EXPECT_EQ(*parse_value(ValueType::i32, "200000"), 0x00030D40U);
  EXPECT_EQ(*parse_value(ValueType::i32, "-2147483648"), 0x80000000U);
  EXPECT_EQ(*parse_value(ValueType::u64, "18446744073709551615"), 0xFFFF'FFFF'FFFF'FFFFU);
  EXPECT_EQ(*parse_value(ValueType::i64, "9223372036854775807"), 0x7FFF'FFFF'FFFF'FFFFU);
  EXPECT_EQ(*parse_value(ValueType::i64, "-9223372036854775808"), 0x8000'0000'0000'0000U);
  EXPECT_EQ(*parse_value(ValueType::u16, "-0"), 0U);
}

TEST(Value, IsReadInHexAsItsBits) {
  EXPECT_EQ(*parse_value(ValueType::u16, "0xD8"), 0x00D8U);
  EXPECT_EQ(*parse_value(ValueType::i16, "0XfffE"), 0xFFFEU);
  EXPECT_EQ(*parse_value(ValueType::i32, "0xFFFFFFFB"), 0xFFFFFFFBU);
  EXPECT_EQ(*parse_value(ValueType::f32, "0x3FC00000"), 0x3FC00000U);
  EXPECT_EQ(*parse_value(ValueType::i64, "0xFFFFFFFFFFFFFFFE"), 0xFFFF'FFFF'FFFF'FFFEU);
  EXPECT_EQ(*parse_value(ValueType::f64, "0x3FF8000000000000"), 0x3FF8'0000'0000'0000U);
}

TEST(Value, IsReadAsAFloat) {
  EXPECT_EQ(*parse_value(ValueType::f32, "1.5"), 0x3FC00000U);
  EXPECT_EQ(*parse_value(ValueType::f32, "-2e3"), 0xC4FA0000U);
  EXPECT_EQ(*parse_value(ValueType::f32, "7"), 0x40E00000U);
  EXPECT_EQ(*parse_value(ValueType::f64, "1.5"), 0x3FF8'0000'0000'0000U);
  EXPECT_EQ(*parse_value(ValueType::f64, "0.1"), 0x3FB9'9999'9999'999AU);
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
  EXPECT_EQ(error_of(ValueType::u64, "18446744073709551616"),
            "\"18446744073709551616\" is outside u64, 0 to 18446744073709551615");
  EXPECT_EQ(error_of(ValueType::u64, "-1"), "\"-1\" is outside u64, 0 to 18446744073709551615");
  EXPECT_EQ(error_of(ValueType::i64, "9223372036854775808"),
            "\"9223372036854775808\" is outside i64, -9223372036854775808 to "
            "9223372036854775807");
  EXPECT_EQ(error_of(ValueType::i64, "-9223372036854775809"),
            "\"-9223372036854775809\" is outside i64, -9223372036854775808 to "
            "9223372036854775807");
  EXPECT_EQ(error_of(ValueType::i32, "99999999999999999999"),
            "\"99999999999999999999\" is outside i32, -2147483648 to 2147483647");
  EXPECT_EQ(error_of(ValueType::i64, "0x10000000000000000"),
            "\"0x10000000000000000\" has more than 64 bits");
  EXPECT_EQ(error_of(ValueType::bit, "2"), "\"2\" is not a bit: 0, 1, off or on");
}

TEST(Value, ThatIsNoneIsRefused) {
  for (const auto* text :
       {"", "abc", "1x", " 1", "1.5", "+1", "--1", "-", "99999999999999999999x"}) {
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
  for (const auto* text : {"", "nan", "-inf", "1e999", "1,5"}) {
    EXPECT_EQ(error_of(ValueType::f64, text),
              "\"" + std::string(text) + "\" is not a number that f64 can hold");
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
  EXPECT_EQ(value_line(2, ValueType::i64, 0xFFFF'FFFF'FFFF'FFFB), "2: -5 (0xFFFFFFFFFFFFFFFB)");
  EXPECT_EQ(value_line(2, ValueType::f64, 0x3FF8'0000'0000'0000), "2: 1.5 (0x3FF8000000000000)");
  EXPECT_EQ(value_line(11, ValueType::bit, 1), "11: 1 (on)");
  EXPECT_EQ(value_line(11, ValueType::bit, 0), "11: 0 (off)");
}

TEST(Value, IsPrintedAsItIsRead) {
  for (const auto* text : {"0", "-1", "2147483647", "-2147483648"}) {
    EXPECT_EQ(value_text(ValueType::i32, *parse_value(ValueType::i32, text)), text);
  }
  for (const auto* text :
       {"9007199254740993", "-9007199254740993", "9223372036854775807", "-9223372036854775808"}) {
    EXPECT_EQ(value_text(ValueType::i64, *parse_value(ValueType::i64, text)), text);
  }
  EXPECT_EQ(value_text(ValueType::u64, *parse_value(ValueType::u64, "18446744073709551615")),
            "18446744073709551615");
  EXPECT_EQ(value_text(ValueType::f32, *parse_value(ValueType::f32, "-0.1")), "-0.1");
  EXPECT_EQ(value_text(ValueType::f64, *parse_value(ValueType::f64, "-0.1")), "-0.1");
}

TEST(Value, OfAFloatIsReadBackFromItsText) {
  using Single = std::numeric_limits<float>;
  for (const float number :
       {0.1F, -0.0F, 1.0F / 3, 16777216.0F, Single::max(), Single::min(), Single::denorm_min()}) {
    const auto bits = std::bit_cast<std::uint32_t>(number);
    EXPECT_EQ(*parse_value(ValueType::f32, value_text(ValueType::f32, bits)), bits) << number;
  }
  using Double = std::numeric_limits<double>;
  for (const double number : {0.1, -0.0, 1.0 / 3, 9007199254740992.0, Double::max(), Double::min(),
                              Double::denorm_min()}) {
    const auto bits = std::bit_cast<std::uint64_t>(number);
    EXPECT_EQ(*parse_value(ValueType::f64, value_text(ValueType::f64, bits)), bits) << number;
  }
  EXPECT_EQ(value_text(ValueType::f64, std::bit_cast<std::uint64_t>(0.1)), "0.1");
  EXPECT_EQ(value_text(ValueType::f64, std::bit_cast<std::uint64_t>(1e22)), "1e+22");
}

std::vector<std::uint64_t> registers_of(const std::string& text) {
  const std::vector<std::string> words{text};
  return *parse_values(ValueType::text, words);
}

TEST(Text, FillsItsLastRegisterWithAZeroByte) {
  EXPECT_EQ(registers_of("AiC-D"), (std::vector<std::uint64_t>{0x4169, 0x432D, 0x4400}));
  EXPECT_EQ(registers_of("AiC-"), (std::vector<std::uint64_t>{0x4169, 0x432D}));
  EXPECT_EQ(registers_of("\xC4"), (std::vector<std::uint64_t>{0xC400}));
}

TEST(Text, EndsAtTheFirstZeroByte) {
  const auto text = [](const std::vector<std::uint64_t>& registers) { return text_of(registers); };
  EXPECT_EQ(text({0x4169, 0x4300, 0x7878}), "AiC");
  EXPECT_EQ(text({0x4169, 0x0043}), "Ai");
  EXPECT_EQ(text({0x4169, 0x432D}), "AiC-");
  EXPECT_EQ(text({0x0041}), "");
  EXPECT_EQ(text({0x2020, 0x417E}), "  A~");
}

TEST(Text, ShowsWhatCannotBePrinted) {
  const std::vector<std::uint64_t> registers{0x1B0A, 0x7FC4, 0xFF41};
  EXPECT_EQ(text_of(registers), "\\x1B\\x0A\\x7F\\xC4\\xFFA");
}

TEST(Text, IsOneValue) {
  const auto error = [](const std::vector<std::string>& words) {
    return parse_values(ValueType::text, words).error();
  };
  EXPECT_EQ(error({"two", "words"}), "a string is one value: put a text with spaces in quotes");
  EXPECT_EQ(error({""}), "an empty string takes no register: write a 0 as u16 to end a text");
}

}  // namespace
}  // namespace mbgate::ctl
