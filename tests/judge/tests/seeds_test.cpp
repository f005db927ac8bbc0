// SPDX-License-Identifier: Apache-2.0
// A seed is a run: whatever it showed once, it shows again; and the judge can find something.
#include <gtest/gtest.h>

#include "judge/judge.hpp"

namespace mbgate::judge {
namespace {

world::Report run(std::uint64_t seed, std::uint64_t transactions, bool keeps_its_promise = true) {
  world::World world(world::draw_plan(seed), false);
  Judge judge(world);
  world.be_watched_by(judge);
  if (!keeps_its_promise) {
    world.break_promise();
  }
  world.run(transactions);
  return world.report();
}

TEST(Seeds, GiveTheSameSummaryTwice) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    EXPECT_EQ(run(seed, 300).summary(), run(seed, 300).summary()) << "seed " << seed;
  }
}

TEST(Seeds, Differ) { EXPECT_NE(run(1, 100).summary(), run(2, 100).summary()); }

TEST(Seeds, ShowADriverThatJudgesBeforeItReads) {
  world::Report report;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    report.add(run(seed, 200, false));
  }
  EXPECT_GT(report.violations["silence"], 0U);
}

TEST(Random, IsTheSameEverywhere) {
  world::Random random(1);
  EXPECT_EQ(random.below(1000), 279U);
  EXPECT_EQ(random.between(-5, 5), -5);
}

}  // namespace
}  // namespace mbgate::judge
