// SPDX-License-Identifier: Apache-2.0
#include "io/heartbeat.hpp"

#include <gtest/gtest.h>

#include "io/clock.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::io {
namespace {

using namespace std::chrono_literals;

TEST(Heartbeat, TellsOnceForHowLongNothingHasRun) {
  boost::asio::io_context context;
  Heartbeat heartbeat(context, [] {});
  EXPECT_EQ(heartbeat.missed(now() + 1h), std::nullopt);  // it does not beat yet
  heartbeat.beat_while(true);
  const bus::Instant later = now() + 10s;
  const auto missed = heartbeat.missed(later);
  ASSERT_TRUE(missed);
  EXPECT_GE(*missed, 10s);
  EXPECT_EQ(heartbeat.missed(later + Heartbeat::kLongest), std::nullopt);
  EXPECT_EQ(heartbeat.missed(later), std::nullopt);
  heartbeat.beat_while(false);
  EXPECT_EQ(heartbeat.missed(later + 1h), std::nullopt);
}

TEST(Heartbeat, BeatsUntilItIsStopped) {
  boost::asio::io_context context;
  int beats = 0;
  Heartbeat heartbeat(context, [&] { ++beats; });
  heartbeat.beat_while(true);
  EXPECT_TRUE(run_until(context, [&] { return beats == 2; }));
  heartbeat.beat_while(false);
  context.restart();
  context.run();  // nothing is left to wait for
  EXPECT_EQ(beats, 2);
}

TEST(Heartbeat, DoesNotWakeOnceMoreIfABeatStopsIt) {
  boost::asio::io_context context;
  Heartbeat* beating = nullptr;
  Heartbeat heartbeat(context, [&] { beating->beat_while(false); });
  beating = &heartbeat;
  heartbeat.beat_while(true);
  EXPECT_EQ(context.run(), 1U);  // the one beat
}

}  // namespace
}  // namespace mbgate::io
