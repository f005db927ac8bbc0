// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "gateway/access/rule_verdict.hpp"
#include "gateway/limits.hpp"

namespace mbgate::gateway {
namespace {

using namespace std::chrono_literals;

ClientKey client_of(std::uint32_t number) {
  routing::ClientAddress::Octets octets{};
  octets[10] = octets[11] = 0xFF;
  for (std::size_t at = 0; at < 4; ++at) {
    octets[12 + at] = static_cast<std::uint8_t>(number >> (24U - 8U * at));
  }
  return {routing::ClientAddress(octets)};
}

TEST(AccessBook, LetsARateThroughAtOnceAndThenOneAfterTheOther) {
  AccessBook book;
  routing::AccessRule rule;
  rule.per_second = 10;
  const RuleVerdict verdict{true, &rule};
  const auto taken = [&](Instant now) {
    int count = 0;
    while (book.take(verdict, client_of(1), now)) {
      ++count;
    }
    return count;
  };
  EXPECT_EQ(taken(Instant{5s}), 10);
  EXPECT_EQ(taken(Instant{5s + 99ms}), 0);
  EXPECT_EQ(taken(Instant{5s + 100ms}), 1);
  EXPECT_EQ(taken(Instant{5s + 450ms}), 3);
  EXPECT_EQ(taken(Instant{60s}), 10);
  book.forget_rates();
  EXPECT_EQ(taken(Instant{60s}), 10);
}

TEST(AccessBook, CountsEachClientAndEachRuleApart) {
  AccessBook book;
  std::array<routing::AccessRule, 2> rules;
  rules[0].per_second = rules[1].per_second = 1;
  EXPECT_TRUE(book.take({true, &rules[0]}, client_of(1), Instant{}));
  EXPECT_TRUE(book.take({true, &rules[0]}, client_of(2), Instant{}));
  EXPECT_FALSE(book.take({true, &rules[1], &rules[0]}, client_of(1), Instant{}));
  EXPECT_TRUE(book.take({true, &rules[1]}, client_of(1), Instant{}));
  EXPECT_TRUE(book.take({true, nullptr}, client_of(1), Instant{}));
  EXPECT_TRUE(book.take({true, &rules[0], &rules[1]}, client_of(3), Instant{}));
  EXPECT_FALSE(book.take({true, &rules[1]}, client_of(3), Instant{}));
}

TEST(AccessBook, HasRoomForSoManyClientsASecond) {
  AccessBook book;
  routing::AccessRule rule;
  rule.per_second = 1000;
  const RuleVerdict verdict{true, &rule};
  for (std::uint32_t client = 0; client < kRatedClients; ++client) {
    ASSERT_TRUE(book.take(verdict, client_of(client), Instant{}));
  }
  EXPECT_FALSE(book.take(verdict, client_of(kRatedClients), Instant{}));
  EXPECT_TRUE(book.take(verdict, client_of(0), Instant{}));
  EXPECT_TRUE(book.take(verdict, client_of(kRatedClients), Instant{1s}));
}

}  // namespace
}  // namespace mbgate::gateway
