// SPDX-License-Identifier: Apache-2.0
#include "gateway/access/report_limit.hpp"

#include <gtest/gtest.h>

#include "gateway/limits.hpp"

namespace mbgate::gateway {
namespace {

using namespace std::chrono_literals;

ClientInfo numbered(std::uint32_t number) {
  routing::ClientAddress::Octets octets{};
  octets[10] = octets[11] = 0xFF;
  for (std::size_t at = 0; at < 4; ++at) {
    octets[12 + at] = static_cast<std::uint8_t>(number >> (24U - 8U * at));
  }
  return {{}, routing::ClientAddress(octets)};
}

TEST(ReportLimit, TellsSoOftenAMinuteAndCountsTheRest) {
  ReportLimit limit(1);
  EXPECT_EQ(limit.note(numbered(1), Instant{}), 0U);
  EXPECT_EQ(limit.note(numbered(2), Instant{}), 0U);
  EXPECT_EQ(limit.note(numbered(1), Instant{59s}), std::nullopt);
  EXPECT_EQ(limit.note(numbered(1), Instant{60s}), 1U);
  EXPECT_EQ(limit.note(numbered(1), Instant{119s}), std::nullopt);
  ReportLimit other(3);
  for (int report = 0; report < 3; ++report) {
    EXPECT_EQ(other.note(numbered(1), Instant{1s}), 0U);
  }
  EXPECT_EQ(other.note(numbered(1), Instant{1s}), std::nullopt);
  EXPECT_EQ(other.note(numbered(1), Instant{61s}), 1U);
}

TEST(ReportLimit, TakesANetworkOfIpv6ForOneClient) {
  ReportLimit limit(1);
  const auto at = [](const char* text) {
    return ClientInfo{{}, *routing::ClientAddress::parse(text)};
  };
  EXPECT_EQ(limit.note(at("2001:db8::1"), Instant{}), 0U);
  EXPECT_EQ(limit.note(at("2001:db8::2"), Instant{}), std::nullopt);
  EXPECT_EQ(limit.note(at("2001:db8:0:1::1"), Instant{}), 0U);
}

TEST(ReportLimit, CountsAsOneAllForWhomThereIsNoPlace) {
  ReportLimit limit(1);
  for (std::uint32_t client = 0; client < kReportedClients; ++client) {
    ASSERT_EQ(limit.note(numbered(client), Instant{}), 0U);
  }
  EXPECT_EQ(limit.note(numbered(kReportedClients), Instant{}), 0U);
  EXPECT_EQ(limit.note(numbered(kReportedClients + 1), Instant{}), std::nullopt);
  EXPECT_EQ(limit.note(numbered(kReportedClients + 1), Instant{60s}), 0U);
}

}  // namespace
}  // namespace mbgate::gateway
