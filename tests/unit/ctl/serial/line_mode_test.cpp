// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "ctl/serial/serial_port.hpp"

namespace mbgate::ctl {
namespace {

using testing::ElementsAre;

std::vector<std::string> mode_texts(std::string_view bauds, std::string_view parities,
                                    std::string_view stop_bits) {
  std::vector<std::string> texts;
  const auto modes = parse_modes(bauds, parities, stop_bits);
  EXPECT_TRUE(modes) << modes.error();
  for (const auto& mode : *modes) {
    texts.push_back(mode_text(mode));
  }
  return texts;
}

std::string mode_error(std::string_view bauds, std::string_view parities,
                       std::string_view stop_bits) {
  const auto modes = parse_modes(bauds, parities, stop_bits);
  return modes ? "none" : modes.error();
}

TEST(LineModes, AreEveryRateWithEveryParityInTheOrderOfTheLists) {
  EXPECT_THAT(
      mode_texts("19200,9600", "even,none,odd", "1"),
      ElementsAre("19200 8E1", "19200 8N1", "19200 8O1", "9600 8E1", "9600 8N1", "9600 8O1"));
}

TEST(LineModes, HaveTwoStopBitsOnlyWithoutAParity) {
  EXPECT_THAT(mode_texts("9600", "even,none", "2"), ElementsAre("9600 8E1", "9600 8N2"));
  EXPECT_THAT(mode_texts("9600", "even,none", "1,2"),
              ElementsAre("9600 8E1", "9600 8N1", "9600 8N2"));
}

TEST(LineModes, AreTriedOnceEach) {
  EXPECT_THAT(mode_texts("9600,9600", "none,none", "1"), ElementsAre("9600 8N1"));
}

TEST(LineModes, AreNotOfOtherWords) {
  for (const std::string bauds : {"", "0", "9600,", "4000001", "9600 ", "-1", "fast"}) {
    EXPECT_EQ(mode_error(bauds, "even", "1"),
              "\"" + bauds +
                  "\" is not a list of baud rates: 1 to 4000000, with commas, like 9600,19200");
  }
  EXPECT_EQ(mode_error("9600", "even,mark", "1"),
            "\"even,mark\" is not a list of parities: even, none, odd, with commas");
  EXPECT_EQ(mode_error("9600", "even", "3"), "\"3\" is not a list of stop bits: 1, 2 or 1,2");
}

}  // namespace
}  // namespace mbgate::ctl
