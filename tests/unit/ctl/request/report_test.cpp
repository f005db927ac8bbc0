// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <bit>
#include <boost/json.hpp>
#include <limits>
#include <sstream>

#include "ctl/request/carry_out.hpp"

namespace mbgate::ctl {
namespace {

using Values = std::vector<std::uint64_t>;

ReadCommand read_in_json(ValueType type) {
  ReadCommand command;
  command.target.unit = 3;
  command.place = {Table::input_registers, 100, type, drive::WordOrder::big};
  command.json = true;
  return command;
}

/// The text of the first value in the JSON of a read.
std::string json_of(ValueType type, std::uint64_t bits) {
  const Values values{bits};
  const auto text = read_report(read_in_json(type), values);
  const auto object = boost::json::parse(text);
  return boost::json::serialize(object.at("values").at(0).at("value"));
}

double number_of(ValueType type, std::uint64_t bits) {
  return boost::json::parse(json_of(type, bits)).to_number<double>();
}

TEST(Report, OfAReadHasALineAValue) {
  auto command = read_in_json(ValueType::i64);
  command.json = false;
  const Values values{5, 0xFFFF'FFFF'FFFF'FFFE};
  EXPECT_EQ(read_report(command, values),
            "100: 5 (0x0000000000000005)\n104: -2 (0xFFFFFFFFFFFFFFFE)\n");
  command.quiet = true;
  EXPECT_EQ(read_report(command, values), "5\n-2\n");
}

TEST(Report, OfAReadInJsonHasEachValueWithItsAddress) {
  const Values values{200000, 0xFFFFFFFB};
  EXPECT_EQ(read_report(read_in_json(ValueType::i32), values),
            R"({"unit":3,"table":"input","values":[{"address":100,"value":200000},)"
            R"({"address":102,"value":-5}]})"
            "\n");
}

TEST(Report, InJsonKeepsEveryDigit) {
  EXPECT_EQ(json_of(ValueType::u64, 0xFFFF'FFFF'FFFF'FFFF), "18446744073709551615");
  EXPECT_EQ(json_of(ValueType::u64, 9007199254740993), "9007199254740993");
  EXPECT_EQ(json_of(ValueType::i64, 0x8000'0000'0000'0000), "-9223372036854775808");
  EXPECT_EQ(json_of(ValueType::u32, 0xFFFFFFFF), "4294967295");
  EXPECT_EQ(json_of(ValueType::i16, 0xFFFE), "-2");
  EXPECT_EQ(json_of(ValueType::bit, 1), "true");
}

TEST(Report, InJsonHasFloatsThatAreReadBack) {
  EXPECT_EQ(number_of(ValueType::f64, std::bit_cast<std::uint64_t>(0.1)), 0.1);
  EXPECT_EQ(number_of(ValueType::f64, std::bit_cast<std::uint64_t>(-1e300)), -1e300);
  // 0.1, not what a double makes of an f32: 0.10000000149011612.
  EXPECT_EQ(number_of(ValueType::f32, std::bit_cast<std::uint32_t>(0.1F)), 0.1);
  for (const float number : {1.0F / 3, std::numeric_limits<float>::max(),
                             std::numeric_limits<float>::denorm_min(), 16777215.0F}) {
    const auto read = number_of(ValueType::f32, std::bit_cast<std::uint32_t>(number));
    EXPECT_EQ(static_cast<float>(read), number);
  }
}

TEST(Report, InJsonHasWordsForWhatIsNoNumber) {
  EXPECT_EQ(json_of(ValueType::f32, 0x7FC00000), R"("nan")");
  EXPECT_EQ(json_of(ValueType::f32, 0x7F800000), R"("inf")");
  EXPECT_EQ(json_of(ValueType::f64, 0xFFF0'0000'0000'0000), R"("-inf")");
}

TEST(Report, OfATextIsOneValue) {
  const Values registers{0x4169, 0x430A, 0x5C22, 0x0000, 0x7878};
  EXPECT_EQ(read_report(read_in_json(ValueType::text), registers),
            R"({"unit":3,"table":"input","values":[{"address":100,"value":"AiC\\x0A\\\""}]})"
            "\n");
  WriteCommand write;
  write.place = {Table::holding_registers, 60, ValueType::text, drive::WordOrder::big};
  write.values = {0x4169, 0x4300};
  write.json = true;
  EXPECT_EQ(write_report(write), R"({"unit":1,"table":"holding","address":60,"written":1})"
                                 "\n");
}

TEST(Report, OfAWriteCountsTheValues) {
  WriteCommand write;
  write.place = {Table::coils, 11, ValueType::bit, drive::WordOrder::big};
  write.values = {1, 0};
  EXPECT_EQ(write_report(write), "11: 1 (on) written\n12: 0 (off) written\n");
  write.quiet = true;
  EXPECT_EQ(write_report(write), "");
  write.json = true;
  EXPECT_EQ(write_report(write), R"({"unit":1,"table":"coils","address":11,"written":2})"
                                 "\n");
}

TEST(Report, OfAFailureHasTheExceptionIfOneCame) {
  const auto json_of = [](const Failure& failure) {
    std::ostringstream out;
    std::ostringstream errors;
    EXPECT_EQ(report_failure(failure, true, out, errors), failure.status);
    EXPECT_EQ(errors.str(), "");
    return out.str();
  };
  EXPECT_EQ(json_of({1, "no valid answer came", 0x0B}),
            "{\"error\":\"no valid answer came\",\"exception\":11}\n");
  EXPECT_EQ(json_of({2, "Connection refused"}), "{\"error\":\"Connection refused\"}\n");
}

}  // namespace
}  // namespace mbgate::ctl
