// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "config/toml/toml_value.hpp"

namespace mbgate::config {
namespace {

using namespace std::chrono_literals;

TEST(ParseDuration, KnowsEveryUnit) {
  EXPECT_EQ(parse_duration("250us"), 250us);
  EXPECT_EQ(parse_duration("300ms"), 300ms);
  EXPECT_EQ(parse_duration("2s"), 2s);
  EXPECT_EQ(parse_duration("10m"), 10min);
  EXPECT_EQ(parse_duration("1h"), 1h);
  EXPECT_EQ(parse_duration("0s"), 0s);
}

TEST(ParseDuration, TakesFractionsExactly) {
  EXPECT_EQ(parse_duration("1.75ms"), 1750us);
  EXPECT_EQ(parse_duration("0.001us"), 1ns);
  EXPECT_EQ(parse_duration("1.5h"), 90min);
  EXPECT_EQ(parse_duration("0.1s"), 100ms);
  EXPECT_EQ(parse_duration("2.50000000000000s"), 2500ms);
}

TEST(ParseDuration, RefusesWhatIsFinerThanANanosecond) {
  EXPECT_EQ(parse_duration("0.0001us"), std::nullopt);
  EXPECT_EQ(parse_duration("0.00000000000001us"), std::nullopt);
  EXPECT_EQ(parse_duration("1.0000000001s"), std::nullopt);
}

TEST(ParseDuration, RefusesWhatIsNoNumberWithAUnit) {
  for (const auto* text : {"", "ms", "300", "300 ms", " 300ms", "-1s", "+1s", "1e3ms", ".5s", "5.s",
                           "1d", "1S", "1.5.5s", "0x10ms", "1ms2"}) {
    EXPECT_EQ(parse_duration(text), std::nullopt) << text;
  }
}

TEST(ParseDuration, EndsAt1000Hours) {
  EXPECT_EQ(parse_duration("1000h"), 1000h);
  EXPECT_EQ(parse_duration("1000.1h"), std::nullopt);
  EXPECT_EQ(parse_duration("1001h"), std::nullopt);
  EXPECT_EQ(parse_duration("99999999999999999999999999us"), std::nullopt);
}

TEST(DurationText, UsesTheLargestUnitWithoutAFraction) {
  EXPECT_EQ(to_text(0s), "0s");
  EXPECT_EQ(to_text(1h), "1h");
  EXPECT_EQ(to_text(90min), "90m");
  EXPECT_EQ(to_text(2s), "2s");
  EXPECT_EQ(to_text(300ms), "300ms");
}

TEST(DurationText, FallsBackToDecimals) {
  EXPECT_EQ(to_text(1750us), "1.75ms");
  EXPECT_EQ(to_text(2005208ns), "2.005208ms");
  EXPECT_EQ(to_text(250us), "250us");
  EXPECT_EQ(to_text(1ns), "0.001us");
}

TEST(DurationText, IsReadBackAsWritten) {
  for (const auto duration : {1ns, 999ns, 1001ns, 999999ns, 1000001ns, 59999999999ns}) {
    EXPECT_EQ(parse_duration(to_text(duration)), duration) << to_text(duration);
  }
}

}  // namespace
}  // namespace mbgate::config
