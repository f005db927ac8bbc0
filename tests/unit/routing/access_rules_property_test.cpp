// SPDX-License-Identifier: Apache-2.0
// The rule engine against a second one. MBGATE_RULE_CASES says how many random lists of rules, each
// with a request; by default a slice.
#include <gtest/gtest.h>

#include <cstdlib>

#include "unit/routing/naive_rules.hpp"

namespace mbgate::test {
namespace {

/// The index of the rule that decides; -1: none does.
int naive_decision(const Case& asked) {
  for (std::size_t at = 0; at < asked.rules.size(); ++at) {
    if (Naive(asked.rules[at], asked).matches()) {
      return static_cast<int>(at);
    }
  }
  return -1;
}

std::uint64_t cases() {
  const char* const given = std::getenv("MBGATE_RULE_CASES");
  return given == nullptr ? 20'000 : std::strtoull(given, nullptr, 10);
}

/// What is not known of a request never makes it less permitted.
void expect_more_with_less(const Case& asked, Dice& dice, std::uint64_t seed) {
  AccessQuestion less = asked.question();
  less.unit = dice.one_in(2) ? std::nullopt : less.unit;
  less.function = dice.one_in(2) ? std::nullopt : less.function;
  less.is_read = dice.one_in(2) ? std::nullopt : less.is_read;
  less.touched = dice.one_in(2) ? std::nullopt : less.touched;
  less.role = dice.one_in(2) && asked.role.kind != ClientRole::Kind::none ? nullptr : less.role;
  EXPECT_TRUE(decide(asked.rules, less).permitted) << "seed " << seed;
}

/// A rule that an earlier one hides matches nothing that the earlier one does not.
void expect_hidden(const Case& asked, std::uint64_t seed) {
  for (const AccessRule& earlier : asked.rules) {
    for (const AccessRule& later : asked.rules) {
      if (hides(earlier, later) && Naive(later, asked).matches()) {
        EXPECT_TRUE(Naive(earlier, asked).matches()) << "seed " << seed;
      }
    }
  }
}

TEST(AccessRulesProperty, AgreesWithANaiveImplementation) {
  const auto devices = known_devices();
  std::array<std::uint64_t, 3> seen{};  // permitted, denied by a rule, matched by none
  const std::uint64_t count = cases();
  for (std::uint64_t seed = 1; seed <= count && !testing::Test::HasFailure(); ++seed) {
    Dice dice(seed);
    const Case asked = some_case(dice, devices);
    const int expected = naive_decision(asked);
    const auto decision = decide(asked.rules, asked.question());
    const int found =
        decision.rule == nullptr ? -1 : static_cast<int>(decision.rule - asked.rules.data());
    const bool permitted = expected < 0 ? asked.rules.empty()
                                        : asked.rules[static_cast<std::size_t>(expected)].permits;
    ASSERT_EQ(found, expected) << "seed " << seed;
    ASSERT_EQ(decision.permitted, permitted) << "seed " << seed;
    ++seen.at(expected < 0 ? 2U : permitted ? 0U : 1U);
    if (permitted) {
      expect_more_with_less(asked, dice, seed);
    }
    expect_hidden(asked, seed);
  }
  for (const std::uint64_t kind : seen) {
    EXPECT_GT(kind, count / 20) << "the requests are no test";
  }
}

}  // namespace
}  // namespace mbgate::test
