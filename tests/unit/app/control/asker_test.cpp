// SPDX-License-Identifier: Apache-2.0
#include "app/control/asker.hpp"

#include <gtest/gtest.h>

namespace mbgate::app {
namespace {

using Verdict = CommandLimit::Verdict;
constexpr CommandLimit::Instant kFirstSecond{};

TEST(CommandLimit, IsTenASecondOfEachClient) {
  CommandLimit limit;
  for (int i = 0; i < 10; ++i) {
    EXPECT_EQ(limit.count("uid 1", kFirstSecond), Verdict::allowed);
  }
  const auto late = kFirstSecond + std::chrono::milliseconds(999);
  EXPECT_EQ(limit.count("uid 1", late), Verdict::first_too_many);
  EXPECT_EQ(limit.count("uid 1", late), Verdict::too_many);
  EXPECT_EQ(limit.count("uid 2", late), Verdict::allowed);
  EXPECT_EQ(limit.count("uid 1", kFirstSecond + std::chrono::seconds(1)), Verdict::allowed);
}

}  // namespace
}  // namespace mbgate::app
