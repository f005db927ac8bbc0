// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "bus/queue/stop_lane.hpp"
#include "support/hex.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;

bus::Job stop_of(std::string_view pdu) {
  bus::Job job;
  job.transactions.push_back({1, *modbus::Request::parse(*modbus::Pdu::from(unhex(pdu)))});
  return job;
}

// A client repeats one stop many times in a second. Another kind of stop is still in a hurry.
TEST(AcknowledgedStops, OneThatIsRepeatedCountsOnce) {
  const bus::Job repeated = stop_of("06 0000 0001");
  const bus::Job other = stop_of("06 0000 0002");
  bus::AcknowledgedStops stops;
  bus::Instant now{};
  for (std::size_t times = 0; times < 2 * bus::kMostDifferentStops; ++times) {
    now += 10ms;
    stops.note(repeated.transactions.front(), now);
  }
  EXPECT_TRUE(stops.has(repeated, now));
  EXPECT_FALSE(stops.has(other, now));
}

TEST(AcknowledgedStops, OfOneDeviceDoNotCountAfterABroadcast) {
  const bus::Job single = stop_of("06 0000 0001");
  bus::Job broadcast = stop_of("06 0000 0001");
  broadcast.transactions.front().broadcast.emplace();
  bus::AcknowledgedStops stops;
  const bus::Instant now{};
  stops.note(single.transactions.front(), now);
  stops.note(broadcast.transactions.front(), now);
  stops.forget_single();
  EXPECT_FALSE(stops.has(single, now));
  EXPECT_TRUE(stops.has(broadcast, now));
}

}  // namespace
}  // namespace mbgate::test
