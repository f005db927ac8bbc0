// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "bus/durations.hpp"

namespace mbgate::bus {
namespace {

using namespace std::chrono_literals;

TEST(DurationsOfADevice, HaveNoPercentileBeforeTheFirst) {
  EXPECT_EQ(Durations().percentile(50), std::nullopt);
}

TEST(DurationsOfADevice, AreNeverShownShorterThanTheyWere) {
  for (Duration duration = 1us; duration < 30s; duration = duration * 21 / 20 + 1us) {
    Durations one;
    one.note(duration);
    EXPECT_GT(*one.percentile(50), duration);
    EXPECT_LE(*one.percentile(50), std::max(duration * 5 / 4, duration + 16us) + 1us)
        << duration.count();
  }
}

TEST(DurationsOfADevice, BeyondTheLastStepCountAsIt) {
  Durations one;
  one.note(1h);
  one.note(-1s);  // a clock that is read late
  EXPECT_GT(*one.percentile(100), 30s);
  EXPECT_EQ(one.percentile(50), Duration{16us});
}

TEST(DurationsOfADevice, AreSharedOut) {
  Durations all;
  for (int at = 0; at < 89; ++at) {
    all.note(1ms);
  }
  for (int at = 0; at < 9; ++at) {
    all.note(10ms);
  }
  all.note(100ms);
  all.note(100ms);
  EXPECT_LT(*all.percentile(50), 2ms);
  EXPECT_LT(*all.percentile(89), 2ms);
  EXPECT_GT(*all.percentile(90), 10ms);
  EXPECT_LT(*all.percentile(98), 13ms);
  EXPECT_GT(*all.percentile(99), 100ms);
}

// 99 percent of 99 are 98.01: of the last one a part is needed, and so all of it.
TEST(DurationsOfADevice, AreEnoughOnlyIfNoPartOfOneIsMissing) {
  Durations all;
  for (int at = 0; at < 98; ++at) {
    all.note(1ms);
  }
  all.note(100ms);
  EXPECT_GT(*all.percentile(99), 100ms);
}

TEST(DurationsOfADevice, OfLongAgoFade) {
  Durations all;
  for (int at = 0; at < 1'000'000; ++at) {
    all.note(100ms);
  }
  for (int at = 0; at < 4'000; ++at) {
    all.note(1ms);
  }
  EXPECT_LT(*all.percentile(50), 2ms);
}

TEST(LatencyOfADevice, OfAnotherCountsOnTheWholeButNotAsOfLate) {
  Latency one;
  one.note(1ms);
  Latency sum;
  sum.note(1ms);
  sum.add_all(one);
  EXPECT_EQ(sum.all().sum(), Duration{2ms});
  Latency none;
  none.add_all(one);
  EXPECT_EQ(none.lately().percentile(50), std::nullopt);
}

}  // namespace
}  // namespace mbgate::bus
