// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "app/control/event_streams.hpp"

namespace mbgate::app {
namespace {

void add_events(EventRing& ring, std::uint64_t first, std::uint64_t last) {
  for (std::uint64_t id = first; id <= last; ++id) {
    ring.add({id, {}, Level::info, "line " + std::to_string(id)});
  }
}

TEST(EventRing, HasNothingAtFirst) {
  const EventRing ring;
  EXPECT_EQ(ring.newest(), 0U);
  EXPECT_EQ(ring.oldest(), 0U);
  EXPECT_FALSE(ring.after(0));
}

TEST(EventRing, GivesWhatComesAfterTheLastOneThatAReaderHad) {
  EventRing ring;
  add_events(ring, 1, 3);
  const auto first = ring.after(0);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->event.text, "line 1");
  EXPECT_EQ(first->lost, 0U);
  const auto third = ring.after(2);
  ASSERT_TRUE(third);
  EXPECT_EQ(third->event.id, 3U);
  EXPECT_EQ(third->lost, 0U);
  EXPECT_FALSE(ring.after(3));
  EXPECT_EQ(ring.newest(), 3U);
}

TEST(EventRing, KeepsTheLatestAndCountsWhatAReaderHasMissed) {
  EventRing ring;
  add_events(ring, 1, EventRing::kSize);
  EXPECT_EQ(ring.after(0)->lost, 0U);
  add_events(ring, EventRing::kSize + 1, EventRing::kSize + 10);
  const auto next = ring.after(4);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->event.id, 11U);
  EXPECT_EQ(next->lost, 6U);
  EXPECT_EQ(ring.oldest(), 11U);
  EXPECT_EQ(ring.after(11)->lost, 0U);
}

TEST(EventRing, CountsWhatNeverCameAsLost) {
  EventRing ring;
  add_events(ring, 1, 2);
  add_events(ring, 6, 6);
  const auto next = ring.after(2);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->event.id, 6U);
  EXPECT_EQ(next->lost, 3U);
}

}  // namespace
}  // namespace mbgate::app
