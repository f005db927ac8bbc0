// SPDX-License-Identifier: Apache-2.0
// Several transmissions that a device has not answered.
#include <algorithm>

#include "bus/health/hold.hpp"
#include "health_rig.hpp"

namespace mbgate::test {
namespace {

// A later request that its answer would fit too is no retry, and its answer may have come.
TEST_F(Health, AnotherRequestIsShownToBeLateByItsOwnTimeout) {
  unanswered(read_, 100ms);
  unanswered(other_read_, 210ms);
  const auto seen = late(kAnswer, 250ms);
  ASSERT_TRUE(seen);
  EXPECT_EQ(seen->shown, 40ms);
}

TEST_F(Health, OfManyUnansweredOnesTheOldestIsForgotten) {
  for (std::size_t count = 1; count <= bus::kMostUnanswered + 1; ++count) {
    unanswered(read_, 100ms);
    EXPECT_EQ(owed(read_), std::min(count, bus::kMostUnanswered));
  }
}

}  // namespace
}  // namespace mbgate::test
