// SPDX-License-Identifier: Apache-2.0
// Requests that come too often are refused.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

/// Unit 250 has no route, so its answer comes at once.
std::string unrouted(unsigned transaction) { return read_request(transaction, 250); }
std::string refused(unsigned transaction, unsigned unit = 250, std::string_view code = "0A") {
  char text[64];
  std::snprintf(text, sizeof text, "00 %02X 00 00 00 03 %02X 83 %s", transaction, unit,
                code.data());
  return text;
}

Settings slow_plant(unsigned most) {
  Settings settings = stop_plant(16);
  settings.listeners[0].max_requests_per_second = most;
  return settings;
}

/// A client that has used up its second.
class OverRate : public testing::Test {
 protected:
  OverRate() {
    rig_.connect(1);
    rig_.receive(1, unrouted(1) + unrouted(2));
    rig_.take_sent(1);
    rig_.events.clear();
  }
  [[nodiscard]] const gateway::ListenerCounters counters() {
    return rig_.harness.gateway().report_status(0s, rig_.now()).listeners[0].counters;
  }

  MachineRig rig_{slow_plant(2)};
};

TEST_F(OverRate, ARequestGets06AtOnce) {
  rig_.receive(1, read_request(3) + write_request(4));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(refused(3, 1, "06"), busy(4)));
  EXPECT_THAT(rig_.take_transmitted(), testing::IsEmpty());
  rig_.advance(499ms);
  rig_.receive(1, read_request(5));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(refused(5, 1, "06")));
  rig_.advance(1ms);
  rig_.receive(1, read_request(6));
  EXPECT_THAT(take_requests(rig_), ElementsAre(kRead1));
}

TEST_F(OverRate, TheOperatorIsToldOnceAMinute) {
  for (unsigned second = 0; second < 61; ++second) {
    rig_.receive(1, unrouted(3) + unrouted(4) + unrouted(5));
    rig_.advance(1s);
  }
  const auto told =
      "listener plant: client 192.0.2.1 sends more than max_requests_per_second (2): requests "
      "beyond that get exception 06, stops excepted";
  EXPECT_THAT(rig_.events, ElementsAre(told, told));
  EXPECT_EQ(counters().over_rate, 61U + 2U);  // nothing was left for the first two
}

TEST_F(OverRate, OtherAddressesAreNot) {
  rig_.connect(2, "192.0.2.2");
  rig_.receive(2, unrouted(1));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre(refused(1)));
}

TEST_F(OverRate, TheConnectionsOfAnAddressCountTogether) {
  rig_.connect(2);
  rig_.receive(2, read_request(1));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre(refused(1, 1, "06")));
}

TEST_F(OverRate, StopsNeverAreHoweverManyThereAre) {
  constexpr unsigned kStops = 40;
  std::string stops;
  for (unsigned number = 1; number <= kStops; ++number) {
    stops += stop_request(number);
  }
  rig_.receive(1, stops);
  for (unsigned number = 1; number <= kStops; ++number) {
    rig_.respond(kStop1);
    rig_.advance(3ms);
  }
  EXPECT_THAT(rig_.take_sent(1), SizeIs(kStops));
  EXPECT_EQ(counters().over_rate, 0U);
}

TEST_F(OverRate, AReloadThatLiftsTheLimitLetsThemGo) {
  rig_.reload(slow_plant(0));
  rig_.receive(1, unrouted(3));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(refused(3)));
}

}  // namespace
}  // namespace mbgate::test
