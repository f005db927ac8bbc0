// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/period.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace mbgate::ctl {
namespace {

using namespace std::chrono_literals;

TEST(Period, StartsAWholeNumberOfPeriodsAfterTheLastStart) {
  const std::chrono::steady_clock::time_point start(1h);
  EXPECT_EQ(next_start(start, 100ms, start), start + 100ms);
  EXPECT_EQ(next_start(start, 100ms, start + 99ms), start + 100ms);
  EXPECT_EQ(next_start(start, 100ms, start + 100ms), start + 100ms);
  EXPECT_EQ(next_start(start, 100ms, start + 101ms), start + 200ms);
  EXPECT_EQ(next_start(start, 100ms, start + 5s), start + 5s);
  EXPECT_EQ(next_start(start, 100ms, start + 5s + 1ns), start + 5100ms);
}

// The hour, and in some places the minute, depend on where this runs.
TEST(Period, TimeOfDayHasThreeDigitsOfASecond) {
  EXPECT_THAT(time_of_day(std::chrono::system_clock::time_point(27s + 5ms)),
              testing::MatchesRegex("[0-9]+:[0-9]+:27\\.005"));
}

}  // namespace
}  // namespace mbgate::ctl
