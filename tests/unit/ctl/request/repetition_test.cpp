// SPDX-License-Identifier: Apache-2.0
#include "ctl/request/repetition.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

namespace mbgate::ctl {
namespace {

using namespace std::chrono_literals;
using std::chrono::steady_clock;

TEST(Interruption, EndsAWait) {
  const Interruption interruption;
  EXPECT_FALSE(interruption.wait_until(steady_clock::now() - std::chrono::hours(1)));
  for (const int signal : {SIGINT, SIGTERM}) {
    raise(signal);
    EXPECT_TRUE(interruption.wait_until(steady_clock::now() + std::chrono::hours(1)));
  }
}

TEST(Interruption, WaitsUntilTheInstant) {
  const Interruption interruption;
  const auto when = steady_clock::now() + std::chrono::milliseconds(2);
  EXPECT_FALSE(interruption.wait_until(when));
  EXPECT_GE(steady_clock::now(), when);
}

TEST(InterruptionDeathTest, EndsTheProcessDuringWorkThatMayBeEnded) {
  const auto work = [](int signal) {
    const Interruption interruption;
    interruption.endable([&] { return raise(signal); });
    _exit(3);
  };
  EXPECT_EXIT(work(SIGINT), testing::ExitedWithCode(0), "");
  EXPECT_EXIT(work(SIGTERM), testing::ExitedWithCode(0), "");
}

TEST(InterruptionDeathTest, HoldsSignalsBackOtherwise) {
  const auto work = [] {
    const Interruption interruption;
    raise(SIGTERM);
    _exit(interruption.wait_until({}) ? 3 : 4);
  };
  EXPECT_EXIT(work(), testing::ExitedWithCode(3), "");
}

TEST(Period, StartsAWholeNumberOfPeriodsAfterTheLastStart) {
  const std::chrono::steady_clock::time_point start(1h);
  EXPECT_EQ(next_start(start, 100ms, start), start + 100ms);
  EXPECT_EQ(next_start(start, 100ms, start + 99ms), start + 100ms);
  EXPECT_EQ(next_start(start, 100ms, start + 100ms), start + 100ms);
  EXPECT_EQ(next_start(start, 100ms, start + 101ms), start + 200ms);
  EXPECT_EQ(next_start(start, 100ms, start + 5s), start + 5s);
  EXPECT_EQ(next_start(start, 100ms, start + 5s + 1ns), start + 5100ms);
}

// The hour, and in some places the minute, depend on where this runs.
TEST(Period, TimeOfDayIsAsExactAsTheInstant) {
  EXPECT_THAT(time_of_day(std::chrono::sys_time<std::chrono::milliseconds>(27s + 5ms)),
              testing::MatchesRegex("[0-9]+:[0-9]+:27\\.005"));
  EXPECT_THAT(time_of_day(std::chrono::sys_time<std::chrono::microseconds>(27s + 5us)),
              testing::MatchesRegex("[0-9]+:[0-9]+:27\\.000005"));
  EXPECT_THAT(time_of_day_now(), testing::MatchesRegex("[0-9]+:[0-9]+:[0-9]+\\.[0-9][0-9][0-9]"));
}

}  // namespace
}  // namespace mbgate::ctl
