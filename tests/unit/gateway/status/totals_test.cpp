// SPDX-License-Identifier: Apache-2.0
// What the status report counts without end, for those who collect metrics.
#include <gmock/gmock.h>

#include <numeric>

#include "support/machine_rig.hpp"

namespace mbgate::test {
namespace {

using gateway::RefusalReason;
using testing::ElementsAre;

Settings axis_and_lift_for_one() {
  Settings settings = one_bus();
  settings.buses[0].timing.retries = 0;
  settings.listeners[0].max_connections = 1;
  settings.listeners[0].keep = {*routing::Network::parse("192.0.2.7")};
  settings.devices = {{"axis", BusId{0}, 1, settings.buses[0].timing},
                      {"lift", BusId{0}, 2, settings.buses[0].timing}};
  return settings;
}

std::uint64_t all(const bus::Histogram& histogram) {
  return std::reduce(histogram.counts().begin(), histogram.counts().end());
}

class Totals : public testing::Test {
 protected:
  Totals() { rig_.connect(1, "192.0.2.7"); }
  [[nodiscard]] gateway::StatusReport report() {
    return rig_.harness.gateway().report_status(60s, rig_.now());
  }
  void ask_and_answer() {
    rig_.receive(1, read_request(1, 1));
    rig_.advance(30ms);
    rig_.respond("01 03 02 12 34");
    rig_.advance(30ms);
  }

  MachineRig rig_{axis_and_lift_for_one()};
};

// 8 characters of 11 bits at 19200 baud, the drive's time, 7 characters and the silence: all of it
// is the line's time, and this drive's.
TEST_F(Totals, OfALineAreThoseOfItsDevices) {
  ask_and_answer();
  const auto shown = report();
  EXPECT_GT(shown.buses[0].busy, 30ms);
  EXPECT_LT(shown.buses[0].busy, 40ms);
  EXPECT_EQ(shown.devices[0].counters.wire_time, shown.buses[0].busy);
  EXPECT_EQ(shown.devices[1].counters.wire_time, Duration{0});
}

TEST_F(Totals, OfADeviceThatDoesNotAnswerHaveItsTimeout) {
  rig_.receive(1, read_request(1, 2));
  rig_.advance(60ms);
  EXPECT_EQ(report().devices[1].counters.wire_time, Duration{0});  // it is not over
  EXPECT_EQ(report().buses[0].busy, Duration{60ms});
  rig_.advance(400ms);
  const auto shown = report();
  EXPECT_GT(shown.devices[1].counters.wire_time, 100ms);
  EXPECT_EQ(shown.devices[1].counters.wire_time, shown.buses[0].busy);
}

TEST_F(Totals, HaveEachSilenceAndLatencyOnce) {
  for (int at = 0; at < 3; ++at) {
    ask_and_answer();
  }
  const auto shown = report();
  EXPECT_EQ(all(shown.buses[0].silences), 3U);
  EXPECT_EQ(all(shown.devices[0].times.queue.all()), 3U);
  EXPECT_EQ(all(shown.devices[0].times.wire.all()), 3U);
  EXPECT_EQ(all(shown.devices[0].times.device.all()), 3U);
  EXPECT_EQ(all(shown.devices[1].times.device.all()), 0U);
}

// Back to back the silence is that of the specification: 3.5 characters of 11 bits.
TEST_F(Totals, HaveTheSilenceBetweenTwoFrames) {
  for (const unsigned transaction : {1U, 2U}) {
    rig_.receive(1, read_request(transaction, 1));
  }
  rig_.advance(30ms);
  rig_.respond("01 03 02 12 34");
  rig_.advance(30ms);
  const auto silences = report().buses[0].silences;
  ASSERT_EQ(all(silences), 2U);
  const auto place = std::ranges::find(silences.bounds(), Duration{2500us});
  ASSERT_NE(place, silences.bounds().end());
  EXPECT_EQ(silences.counts()[static_cast<std::size_t>(place - silences.bounds().begin())], 1U);
}

TEST_F(Totals, SayHowLongTheOldestRequestWaits) {
  rig_.receive(1, read_request(1, 1));
  rig_.receive(1, read_request(2, 2));
  rig_.advance(20ms);
  EXPECT_EQ(report().buses[0].longest_waiting, Duration{20ms});
  rig_.advance(600ms);
  EXPECT_EQ(report().buses[0].longest_waiting, Duration{0});
}

TEST_F(Totals, CountWhatCameToAListener) {
  ask_and_answer();
  rig_.receive(1, read_request(2, 248));  // no route
  rig_.connect(2, "192.0.2.8");           // no room
  const auto shown = report();
  ASSERT_EQ(shown.listeners.size(), 1U);
  EXPECT_EQ(shown.listeners[0].name, "plant");
  EXPECT_EQ(shown.listeners[0].connections, 1U);
  const auto& counters = shown.listeners[0].counters;
  EXPECT_EQ(counters.connections, 1U);
  EXPECT_EQ(counters.requests, 2U);
  EXPECT_EQ(counters.refused_reads.of(0x0A), 1U);
  EXPECT_EQ(counters.refused_writes.of(0x0A), 0U);
  EXPECT_THAT(counters.refused_connections, ElementsAre(0, 1, 0, 0, 0, 0));
}

TEST_F(Totals, CountWhatWasNotAnsweredAsRefused) {
  rig_.receive(1, read_request(1, 1));
  rig_.advance(600ms);
  EXPECT_EQ(report().listeners[0].counters.refused_reads.of(0x0B), 1U);
}

TEST_F(Totals, BeginAnewWhenTheCountersAreCleared) {
  ask_and_answer();
  rig_.harness.handle(gateway::ClearCountersAsked{});
  const auto shown = report();
  EXPECT_EQ(all(shown.buses[0].silences), 0U);
  EXPECT_EQ(all(shown.devices[0].times.device.all()), 0U);
  EXPECT_EQ(shown.devices[0].counters.wire_time, Duration{0});
  EXPECT_EQ(shown.listeners[0].counters.requests, 0U);
  EXPECT_EQ(shown.listeners[0].connections, 1U);
}

}  // namespace
}  // namespace mbgate::test
