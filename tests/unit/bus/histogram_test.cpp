// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "bus/durations.hpp"

namespace mbgate::bus {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;

constexpr std::array<Duration, 2> kBounds = {1ms, 5ms};

TEST(Histogram, CountsABoundWithWhatIsNotLonger) {
  Histogram histogram(kBounds);
  for (const Duration duration : {Duration(0), Duration(1ms), Duration(1ms) + 1ns, Duration(5ms),
                                  Duration(5ms) + 1ns, Duration(1h)}) {
    histogram.note(duration);
  }
  EXPECT_THAT(histogram.counts(), ElementsAre(2, 2, 2));
  EXPECT_EQ(histogram.sum(), 1h + 12ms + 2ns);
}

TEST(Histogram, CountsEachInItsPlaceWhateverCameBefore) {
  Histogram histogram(kBounds);
  for (const Duration duration :
       {Duration(1h), Duration(1h), Duration(0), Duration(1ms), Duration(5ms), Duration(1ms) + 1ns,
        Duration(1ms), Duration(1h), Duration(5ms) + 1ns, Duration(5ms)}) {
    histogram.note(duration);
  }
  EXPECT_THAT(histogram.counts(), ElementsAre(3, 3, 4));
}

TEST(Histogram, AddsWhatAnotherHasCounted) {
  Histogram histogram(kBounds);
  Histogram other(kBounds);
  histogram.note(2ms);
  other.note(2ms);
  other.note(1s);
  histogram.add(other);
  EXPECT_THAT(histogram.counts(), ElementsAre(0, 2, 1));
  EXPECT_EQ(histogram.sum(), 1s + 4ms);
}

}  // namespace
}  // namespace mbgate::bus
