// SPDX-License-Identifier: Apache-2.0
// A seed is a run: whatever it showed once, it shows again; and the judge can find something.
#include <gtest/gtest.h>

#include "judge/run.hpp"

namespace mbgate::judge {
namespace {

world::Report run_seed(std::uint64_t seed, std::uint64_t transactions) {
  return run(world::draw_plan(seed), {.transactions = transactions});
}

TEST(Seeds, GiveTheSameSummaryTwice) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    EXPECT_EQ(run_seed(seed, 300).summary(), run_seed(seed, 300).summary()) << "seed " << seed;
  }
}

TEST(Seeds, Differ) { EXPECT_NE(run_seed(1, 100).summary(), run_seed(2, 100).summary()); }

TEST(Seeds, ShowADriverThatJudgesBeforeItReads) {
  world::Report report;
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    report.add(run(world::draw_plan(seed),
                   {.transactions = 200, .prepare = &world::World::break_promise}));
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
