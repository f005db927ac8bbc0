// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "app/log.hpp"

namespace mbgate::app {
namespace {

const bus::Instant kStart{std::chrono::hours(1)};

TEST(RateLimit, LetsTenLinesThroughAndMarksTheLast) {
  RateLimit limit;
  for (int i = 1; i <= 10; ++i) {
    const auto verdict = limit.count("lost", kStart);
    EXPECT_TRUE(verdict.write) << i;
    EXPECT_EQ(verdict.last, i == 10) << i;
  }
  EXPECT_FALSE(limit.count("lost", kStart).write);
}

TEST(RateLimit, CountsWhatItLeftOut) {
  RateLimit limit;
  for (int i = 0; i < 17; ++i) {
    limit.count("lost", kStart);
  }
  const auto verdict = limit.count("lost", kStart + std::chrono::minutes(1));
  EXPECT_TRUE(verdict.write);
  EXPECT_EQ(verdict.left_out, 7U);
  EXPECT_EQ(limit.count("lost", kStart + std::chrono::minutes(1)).left_out, 0U);
}

TEST(RateLimit, KeepsKindsApart) {
  RateLimit limit;
  for (int i = 0; i < 20; ++i) {
    limit.count("lost", kStart);
  }
  EXPECT_TRUE(limit.count("refused", kStart).write);
}

}  // namespace
}  // namespace mbgate::app
