// SPDX-License-Identifier: Apache-2.0
#include "explore/explorer.hpp"

#include <gmock/gmock.h>

namespace mbgate::explore {
namespace {

Findings explore(const Plant& plant, const Bounds& bounds, Merging merging) {
  return Explorer(plant, bounds, merging).run();
}

std::vector<std::string> kinds_of(const Findings& findings) {
  std::vector<std::string> kinds;
  for (const Violation& violation : findings.violations) {
    kinds.push_back(violation.what);
  }
  return kinds;
}

/// Its devices ask for what the oracle does not allow: writes are repeated.
Plant broken_plant() {
  Plant plant = *find_plant("usual");
  for (drive::Device& device : plant.settings.devices) {
    device.timing.retry_writes = true;
  }
  return plant;
}

TEST(Explorer, FindsNothingInAnyPlant) {
  for (const Plant& plant : plants()) {
    const Findings findings =
        explore(plant, {.requests = 1, .faults = 1, .delays = 1, .forms = true}, Merging::on);
    EXPECT_THAT(kinds_of(findings), testing::IsEmpty()) << plant.name;
  }
}

TEST(Explorer, FindsTheSameWithAndWithoutMerging) {
  const Plant plant = broken_plant();
  const Bounds bounds{.requests = 1, .faults = 1, .delays = 1, .forms = true};
  const Findings merged = explore(plant, bounds, Merging::on);
  const Findings all = explore(plant, bounds, Merging::off);
  EXPECT_THAT(kinds_of(merged), testing::Not(testing::IsEmpty()));
  EXPECT_THAT(kinds_of(merged), testing::UnorderedElementsAreArray(kinds_of(all)));
  EXPECT_LT(merged.states, all.states);
}

// What shows that the reader leaves out nothing that decides something.
TEST(Explorer, AStateThatIsReachedOnceMoreBehavesAsBefore) {
  for (const Plant& plant : plants()) {
    for (const Bounds& bounds : {Bounds{.requests = 1, .faults = 1, .delays = 1, .forms = true},
                                 Bounds{.requests = 2, .instants = 1}}) {
      const Findings findings = explore(plant, bounds, Merging::compared);
      EXPECT_THAT(kinds_of(findings), testing::IsEmpty()) << plant.name;
      EXPECT_GT(findings.merged, 0U);
    }
  }
}

TEST(Explorer, ADeviceThatIsSlowOrAnswersTwiceMisleadsNobody) {
  const Bounds bounds{.requests = 1, .faults = 1, .drives = true, .instants = 1};
  for (const Plant& plant : plants()) {
    const Findings findings = explore(plant, bounds, Merging::compared);
    EXPECT_THAT(kinds_of(findings), testing::IsEmpty()) << plant.name;
    EXPECT_EQ(findings.learning, 0U) << "one request has no other that could be mistaken for it";
  }
}

TEST(Explorer, AViolationIsReplayed) {
  const Plant plant = broken_plant();
  const Bounds bounds{.requests = 1, .faults = 1};
  const Findings findings = explore(plant, bounds, Merging::on);
  ASSERT_THAT(kinds_of(findings), testing::Not(testing::IsEmpty()));
  testing::internal::CaptureStdout();
  const Violation& violation = findings.violations.front();
  EXPECT_EQ(replay(plant, bounds, violation.path), violation.what);
  EXPECT_THAT(testing::internal::GetCapturedStdout(), testing::HasSubstr("ask: write"));
}

TEST(StateHash, AgesBeyondTheirReachAreOne) {
  const auto digest = [](Duration age) {
    StateHash hash(Instant{} + std::chrono::hours(1));
    hash.since(hash.now() - age, Duration{100});
    return hash.digest();
  };
  EXPECT_NE(digest(Duration{99}), digest(Duration{100}));
  EXPECT_EQ(digest(Duration{100}), digest(Duration{101}));
  EXPECT_NE(digest(Duration{-1}), digest(Duration{-2}));
}

TEST(StateHash, OfOrderedNumbersOnlyTheOrderCounts) {
  const auto digest = [](std::vector<std::uint64_t> numbers) {
    StateHash hash(Instant{});
    for (const std::uint64_t number : numbers) {
      hash.ordered(Order::turn, number);
    }
    return hash.digest();
  };
  EXPECT_EQ(digest({3, 9, 3}), digest({1, 2, 1}));
  EXPECT_NE(digest({3, 9, 3}), digest({1, 2, 2}));
  EXPECT_NE(digest({0, 1}), digest({1, 2}));
}

TEST(StateHash, ObjectsAreToldApartByWhenTheyAreMet) {
  const int a = 0;
  const int b = 0;
  const auto digest = [](std::vector<const int*> objects) {
    StateHash hash(Instant{});
    for (const int* object : objects) {
      hash.name(object);
    }
    return hash.digest();
  };
  EXPECT_EQ(digest({&a, &b, &a}), digest({&b, &a, &b}));
  EXPECT_NE(digest({&a, &b, &a}), digest({&a, &b, &b}));
  EXPECT_NE(digest({&a, nullptr}), digest({&a, &b}));
}

TEST(KnownStates, KnowsEachOnce) {
  KnownStates known;
  const auto add = [&known](std::uint64_t number, SlackSet slack, SlackSet covering) {
    return known.add({number * 0x9E37'79B9'7F4A'7C15U, number << 32U}, slack, covering);
  };
  for (std::uint64_t number = 0; number < 100'000; ++number) {
    EXPECT_TRUE(add(number, 1, 1 | 2));
  }
  for (std::uint64_t number = 0; number < 100'000; ++number) {
    EXPECT_FALSE(add(number, 1, 1 | 2));
  }
}

TEST(KnownStates, AStateIsGoneThroughAgainWithMoreSlackAndNotWithLess) {
  KnownStates known;
  const Digest state{7, 7};
  EXPECT_TRUE(known.add(state, 1, 1 | 2));
  EXPECT_TRUE(known.add(state, 2, 2));
  EXPECT_FALSE(known.add(state, 1, 1 | 2));
  EXPECT_FALSE(known.add(state, 2, 2));
}

}  // namespace
}  // namespace mbgate::explore
