// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "app/control/event_streams.hpp"
#include "app/control/trace_streams.hpp"

namespace mbgate::app {
namespace {

constexpr std::uint64_t kSize = 256;

void add_events(Ring<JournalEvent>& ring, std::uint64_t first, std::uint64_t last) {
  for (std::uint64_t id = first; id <= last; ++id) {
    ring.add({id, {}, Level::info, "line " + std::to_string(id)});
  }
}

TEST(Ring, HasNothingAtFirst) {
  const Ring<JournalEvent> ring(kSize);
  EXPECT_EQ(ring.newest(), 0U);
  EXPECT_EQ(ring.oldest(), 0U);
  EXPECT_FALSE(ring.after(0));
}

TEST(Ring, GivesWhatComesAfterTheLastOneThatAReaderHad) {
  Ring<JournalEvent> ring(kSize);
  add_events(ring, 1, 3);
  const auto first = ring.after(0);
  ASSERT_TRUE(first);
  EXPECT_EQ(first->item.text, "line 1");
  EXPECT_EQ(first->lost, 0U);
  const auto third = ring.after(2);
  ASSERT_TRUE(third);
  EXPECT_EQ(third->item.id, 3U);
  EXPECT_EQ(third->lost, 0U);
  EXPECT_FALSE(ring.after(3));
  EXPECT_EQ(ring.newest(), 3U);
}

TEST(Ring, KeepsTheLatestAndCountsWhatAReaderHasMissed) {
  Ring<JournalEvent> ring(kSize);
  add_events(ring, 1, kSize);
  EXPECT_EQ(ring.after(0)->lost, 0U);
  add_events(ring, kSize + 1, kSize + 10);
  const auto next = ring.after(4);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->item.id, 11U);
  EXPECT_EQ(next->lost, 6U);
  EXPECT_EQ(ring.oldest(), 11U);
  EXPECT_EQ(ring.after(11)->lost, 0U);
}

TEST(Ring, CountsWhatNeverCameAsLost) {
  Ring<JournalEvent> ring(kSize);
  add_events(ring, 1, 2);
  add_events(ring, 6, 6);
  const auto next = ring.after(2);
  ASSERT_TRUE(next);
  EXPECT_EQ(next->item.id, 6U);
  EXPECT_EQ(next->lost, 3U);
}

TEST(RingOfTraces, TheOldestMakeRoomForSoManyBytes) {
  Ring<TraceItem> ring(kKeptTraceBytes);
  const std::string long_text(kKeptTraceBytes / 8, 'x');
  for (std::uint64_t id = 1; id <= 20; ++id) {
    ring.add({id, {}, long_text});
  }
  const auto oldest = ring.after(0);
  EXPECT_EQ(oldest->item.id, 18U);
  EXPECT_EQ(oldest->lost, 17U);
}

TEST(RingOfTraces, OneThatIsTooLargeIsStillGiven) {
  Ring<TraceItem> ring(kKeptTraceBytes);
  ring.add({1, {}, std::string(kKeptTraceBytes, 'x')});
  EXPECT_TRUE(ring.after(0));
}

TEST(RingOfTraces, ForgetsNoNumber) {
  Ring<TraceItem> ring(kKeptTraceBytes);
  ring.add({7, {}, "seven"});
  ring.clear();
  EXPECT_FALSE(ring.after(0));
  EXPECT_EQ(ring.newest(), 7U);
}

}  // namespace
}  // namespace mbgate::app
