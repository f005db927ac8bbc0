// SPDX-License-Identifier: Apache-2.0
// A seed is a run: whatever it showed once, it shows again.
#include <gtest/gtest.h>

#include "soak/world.hpp"

namespace mbgate::soak {
namespace {

TEST(Soak, ASeedGivesTheSameSummaryTwice) {
  constexpr std::uint64_t kTransactions = 300;
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    const std::string once = World(seed).run(kTransactions).summary();
    EXPECT_EQ(World(seed).run(kTransactions).summary(), once) << "seed " << seed;
  }
}

TEST(Soak, SeedsDiffer) { EXPECT_NE(World(1).run(100).summary(), World(2).run(100).summary()); }

TEST(Soak, SeesADriverThatJudgesBeforeItReads) {
  constexpr std::uint64_t kSeeds = 30;
  constexpr std::uint64_t kTransactions = 200;
  Report report;
  for (std::uint64_t seed = 1; seed <= kSeeds; ++seed) {
    World world(seed);
    world.break_promise();
    report.add(world.run(kTransactions));
  }
  EXPECT_GT(report.violations["silence"], 0U);
}

TEST(Random, IsTheSameEverywhere) {
  Random random(1);
  EXPECT_EQ(random.below(1000), 279U);
  EXPECT_EQ(random.between(-5, 5), -5);
}

}  // namespace
}  // namespace mbgate::soak
