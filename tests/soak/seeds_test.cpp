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

// Each has shown an error of the product or of the oracle when nobody had tried it before. When a
// plan draws something new, its seed shows another run. One is left out that takes as long as
// twenty.
TEST(Soak, SeedsThatOnceAlarmedDoNotAnyMore) {
  constexpr std::uint64_t kTransactions = 500;
  for (const std::uint64_t seed :
       {101000010U, 110000507U, 110000597U, 110000726U, 110002430U, 120000482U, 120001072U,
        120002199U, 130000144U, 130001828U, 130002335U, 130002400U, 130002477U, 130004589U,
        130005065U, 140001321U, 140002790U, 152000373U, 152001340U, 152001780U, 161001327U,
        161001381U, 161001837U, 180003760U, 190000713U, 190001358U, 200000061U, 200000279U,
        230002037U, 230002560U, 230003313U, 240001685U, 250001686U, 250001997U, 250004238U,
        260003383U, 270004477U, 280000537U, 280004028U, 280004036U, 280004267U, 280004570U,
        290003127U, 300001435U, 300001786U, 710002711U, 710003041U}) {
    const Report report = World(seed).run(kTransactions);
    EXPECT_EQ(report.violations.size(), 0U) << "seed " << seed << '\n' << report.summary();
  }
}

TEST(Random, IsTheSameEverywhere) {
  Random random(1);
  EXPECT_EQ(random.below(1000), 279U);
  EXPECT_EQ(random.between(-5, 5), -5);
}

}  // namespace
}  // namespace mbgate::soak
