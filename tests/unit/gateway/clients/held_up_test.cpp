// SPDX-License-Identifier: Apache-2.0
// Requests that come too often wait for their turn.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// Unit 250 has no route, so its answer comes at once.
std::string unrouted(unsigned transaction) { return read_request(transaction, 250); }
std::string no_route(unsigned transaction) {
  char text[64];
  std::snprintf(text, sizeof text, "00 %02X 00 00 00 03 FA 83 0A", transaction);
  return text;
}

Settings slow_plant(unsigned most) {
  Settings settings = stop_plant(16);
  settings.listeners[0].max_requests_per_second = most;
  return settings;
}

/// A client that has used up its second.
class HeldUp : public testing::Test {
 protected:
  explicit HeldUp(Settings settings = slow_plant(2)) : rig_(std::move(settings)) {
    rig_.connect(1);
    rig_.receive(1, unrouted(1) + unrouted(2));
    rig_.take_sent(1);
    rig_.events.clear();
  }
  [[nodiscard]] const gateway::ListenerCounters counters() {
    return rig_.harness.gateway().report_status(0s, rig_.now()).listeners[0].counters;
  }

  MachineRig rig_;
};

TEST_F(HeldUp, ARequestIsAnsweredWhenItIsItsTurn) {
  rig_.receive(1, unrouted(3) + unrouted(4));
  rig_.advance(499ms);
  EXPECT_THAT(rig_.take_sent(1), IsEmpty());
  rig_.advance(1ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
  rig_.advance(500ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(4)));
}

TEST_F(HeldUp, TheOperatorIsToldOnceAMinute) {
  for (unsigned number = 3; number < 3 + 2 * 61; ++number) {
    rig_.receive(1, unrouted(number));
    rig_.advance(500ms);
  }
  const auto told =
      "listener plant: client 192.0.2.1 sends more than max_requests_per_second (2): its requests "
      "wait for their turn, stops excepted";
  EXPECT_THAT(rig_.events, ElementsAre(told, told));
  EXPECT_EQ(counters().held_up, 2U * 61);
}

TEST_F(HeldUp, OtherAddressesAreNot) {
  rig_.receive(1, unrouted(3));
  rig_.connect(2, "192.0.2.2");
  rig_.receive(2, unrouted(1));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre(no_route(1)));
}

TEST_F(HeldUp, TheConnectionsOfAnAddressTakeTurns) {
  rig_.connect(2);
  rig_.receive(1, unrouted(3) + unrouted(4) + unrouted(5));
  rig_.receive(2, unrouted(1) + unrouted(2));
  rig_.advance(1s);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre(no_route(1)));
  rig_.advance(1s);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(4)));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre(no_route(2)));
}

TEST_F(HeldUp, OneThatGoesGivesItsTurnBack) {
  rig_.connect(2);
  rig_.receive(2, unrouted(1));
  rig_.disconnect(2);
  rig_.receive(1, unrouted(3));
  rig_.advance(500ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
}

TEST_F(HeldUp, WhoWaitsBehindOneThatGoesMovesUp) {
  rig_.connect(2);
  rig_.receive(2, unrouted(1));
  rig_.receive(1, unrouted(3));
  rig_.disconnect(2);
  rig_.connect(3);
  rig_.receive(3, unrouted(1));
  rig_.advance(500ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
  EXPECT_THAT(rig_.take_sent(3), IsEmpty());
  rig_.advance(499ms);
  EXPECT_THAT(rig_.take_sent(3), IsEmpty());
  rig_.advance(1ms);
  EXPECT_THAT(rig_.take_sent(3), ElementsAre(no_route(1)));
}

TEST_F(HeldUp, WhoMovesUpWaitsByTheLimitInForce) {
  rig_.connect(2);
  rig_.connect(3);
  rig_.receive(2, unrouted(1));
  rig_.receive(1, unrouted(3));
  rig_.receive(3, unrouted(1));
  rig_.reload(slow_plant(10));
  rig_.disconnect(2);
  rig_.advance(100ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
  EXPECT_THAT(rig_.take_sent(3), IsEmpty());
  rig_.advance(100ms);
  EXPECT_THAT(rig_.take_sent(3), ElementsAre(no_route(1)));
}

TEST_F(HeldUp, AReloadThatLowersTheLimitLeavesThemTheirTurns) {
  rig_.connect(2);
  rig_.connect(3);
  rig_.receive(2, unrouted(1));
  rig_.receive(1, unrouted(3));
  rig_.reload(slow_plant(1));
  rig_.disconnect(2);
  rig_.receive(3, unrouted(1));
  rig_.advance(1s);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
  rig_.advance(999ms);
  EXPECT_THAT(rig_.take_sent(3), IsEmpty());
  rig_.advance(1ms);
  EXPECT_THAT(rig_.take_sent(3), ElementsAre(no_route(1)));
}

TEST_F(HeldUp, AStopIsTakenAtOnce) {
  rig_.receive(1, write_request(3) + stop_request(4));
  EXPECT_THAT(take_requests(rig_), ElementsAre(kStop1));
  rig_.respond(kStop1);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(written(4, 1, true)));
}

TEST_F(HeldUp, AStopTakesNoTurnOfOthers) {
  rig_.connect(2);
  rig_.receive(2, stop_request(1));
  rig_.receive(1, unrouted(3));
  rig_.advance(500ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
}

TEST_F(HeldUp, HoweverManyStopsThereAre) {
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
}

TEST_F(HeldUp, TheSocketIsReadNoFurtherThanTheReadAhead) {
  std::string requests;
  for (unsigned number = 0; number < 170; ++number) {
    requests += unrouted(number & 0xFF);
  }
  rig_.receive(1, requests);
  EXPECT_THAT(rig_.paused, IsEmpty());
  rig_.receive(1, requests);
  EXPECT_THAT(rig_.paused, ElementsAre(1));
  rig_.advance(170s);
  EXPECT_THAT(rig_.paused, IsEmpty());
  EXPECT_THAT(rig_.take_sent(1), SizeIs(340));
}

TEST_F(HeldUp, AHalfClosedClientGetsItsAnswers) {
  rig_.receive(1, unrouted(3));
  rig_.half_close(1);
  EXPECT_THAT(rig_.closed, IsEmpty());
  rig_.advance(500ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
  EXPECT_THAT(rig_.closed, ElementsAre(1));
}

TEST_F(HeldUp, IsNotIdleAndNotIncomplete) {
  Settings settings = slow_plant(2);
  settings.listeners[0].idle_timeout = 100ms;
  settings.listeners[0].frame_timeout = 100ms;
  rig_.reload(settings);
  rig_.receive(1, unrouted(3));
  rig_.advance(499ms);
  EXPECT_THAT(rig_.closed, IsEmpty());
  rig_.advance(1ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
}

TEST_F(HeldUp, APartOfARequestTakesNoTurn) {
  rig_.connect(2);
  rig_.receive(2, "00 01 00");
  rig_.receive(1, unrouted(3));
  rig_.advance(500ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
  EXPECT_EQ(counters().held_up, 1U);
}

TEST_F(HeldUp, AReloadThatLiftsTheLimitLetsThemGo) {
  rig_.receive(1, unrouted(3));
  rig_.reload(slow_plant(0));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
}

TEST_F(HeldUp, OneThatGoesGivesBackWhatItTookByTheLimitOfBefore) {
  rig_.connect(2);
  rig_.receive(2, unrouted(1));  // half a second
  rig_.reload(slow_plant(10));
  rig_.disconnect(2);
  rig_.receive(1, unrouted(3));
  rig_.advance(100ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(no_route(3)));
}

TEST_F(HeldUp, AreAnsweredWhenTheGatewayStops) {
  rig_.receive(1, read_request(3));
  rig_.shutdown();
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("00 03 00 00 00 03 01 83 06"));
  EXPECT_TRUE(rig_.finished);
}

}  // namespace
}  // namespace mbgate::test
