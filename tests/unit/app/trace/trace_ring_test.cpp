// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "app/trace/trace_filter.hpp"

namespace mbgate::test {
namespace {

using app::TraceItem;
using app::TraceRing;

TEST(TraceRing, GivesWhatComesAfterARecord) {
  TraceRing ring;
  EXPECT_EQ(ring.newest(), 0U);
  EXPECT_FALSE(ring.after(0));
  ring.add({5, {}, "five"});
  ring.add({6, {}, "six"});
  EXPECT_EQ(ring.newest(), 6U);
  EXPECT_EQ(ring.after(5)->item.text, "six");
  EXPECT_EQ(ring.after(5)->lost, 0U);
  EXPECT_EQ(ring.after(2)->item.text, "five");
  EXPECT_EQ(ring.after(2)->lost, 2U);
  EXPECT_FALSE(ring.after(6));
}

TEST(TraceRing, TheOldestMakeRoom) {
  TraceRing ring;
  const std::string long_text(TraceRing::kMostBytes / 8, 'x');
  for (std::uint64_t id = 1; id <= 20; ++id) {
    ring.add({id, {}, long_text});
  }
  const auto oldest = ring.after(0);
  EXPECT_EQ(oldest->item.id, 18U);
  EXPECT_EQ(oldest->lost, 17U);
}

TEST(TraceRing, OneThatIsTooLargeIsStillGiven) {
  TraceRing ring;
  ring.add({1, {}, std::string(TraceRing::kMostBytes, 'x')});
  EXPECT_TRUE(ring.after(0));
}

TEST(TraceRing, ForgetsNoNumber) {
  TraceRing ring;
  ring.add({7, {}, "seven"});
  ring.clear();
  EXPECT_FALSE(ring.after(0));
  EXPECT_EQ(ring.newest(), 7U);
}

}  // namespace
}  // namespace mbgate::test
