// SPDX-License-Identifier: Apache-2.0
// Lines that are absent, vanish and return; the end of the process.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test::lines_test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

constexpr auto kRead = "0001 0000 0006 01 03 0000 0001";
constexpr auto kRead2 = "0002 0000 0006 01 03 0000 0001";

TEST(Gateway, HoldsRequestsUntilTheFirstAttemptToOpenTheLine) {
  MachineRig rig(one_bus(), false);
  EXPECT_THAT(rig.opened, SizeIs(1));
  rig.connect(1);
  rig.receive(1, kRead);
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
  rig.open_line();
  rig.advance(5ms);
  EXPECT_THAT(rig.take_transmitted(), SizeIs(1));
}

TEST(Gateway, AnswersWith0AAtOnceWhileThePortIsAbsentAndTriesAgain) {
  MachineRig rig(one_bus(), false);
  rig.connect(1);
  rig.receive(1, kRead);
  rig.lose_line();
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 83 0A"));
  rig.receive(1, kRead2);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 01 83 0A"));
  const Instant lost = rig.now();
  std::vector<Duration> waits;
  for (int attempt = 0; attempt < 8; ++attempt) {
    rig.opened.clear();
    const Instant before = rig.now();
    rig.advance(6s);
    ASSERT_THAT(rig.opened, SizeIs(1));
    waits.push_back(rig.opened[0] - before);
    rig.lose_line();
  }
  EXPECT_THAT(waits, ElementsAre(100ms, 200ms, 400ms, 800ms, 1600ms, 3200ms, 5s, 5s));
  EXPECT_GT(rig.now(), lost);
}

TEST(Gateway, AVanishedLineEndsWhatWasOnTheWireWith0BAndTheRestWith0A) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, std::string(kRead) + kRead2);
  rig.lose_line();
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 01 00 00 00 03 01 83 0B", "00 02 00 00 00 03 01 83 0A"));
  EXPECT_THAT(rig.events, ElementsAre("bus line-a is lost; it is being reopened"));
  rig.advance(100ms);
  EXPECT_THAT(rig.opened, SizeIs(1));
  rig.open_line();
  rig.advance(200ms);  // the answer that it owes may still come
  rig.take_transmitted();
  rig.receive(1, kRead);
  EXPECT_THAT(rig.take_transmitted(), SizeIs(1));
}

TEST(Gateway, OpensAnAdapterAgainThatHearsNothingAndSaysSoOnce) {
  Settings settings = one_bus();
  settings.buses[0].hung_requests = 2;
  MachineRig rig(settings, false);
  const auto open = [&] {
    rig.harness.handle(gateway::LineOpened{BusId{0}, bus::LineKind::uart});
    rig.advance(5ms);
  };
  open();
  rig.connect(1);
  for (int reopened = 1; reopened <= 2; ++reopened) {
    rig.receive(1, kRead);
    rig.advance(60s);
    EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 83 0B"));
    rig.opened.clear();
    rig.take_transmitted();
    rig.receive(1, kRead2);
    EXPECT_THAT(rig.take_transmitted(), IsEmpty());
    EXPECT_THAT(rig.opened, SizeIs(1));
    EXPECT_EQ(rig.shut, static_cast<unsigned>(reopened));
    open();
    EXPECT_THAT(rig.take_transmitted(), SizeIs(1)) << "it waited for the line";
    rig.advance(1s);
    rig.take_sent(1);
  }
  EXPECT_THAT(rig.events,
              ElementsAre("bus line-a is open",
                          "bus line-a: not a byte was heard for 60 s, in which 2 requests were "
                          "sent; the adapter may hang, so it is closed and opened again, now and "
                          "at growing intervals until something is heard"));
}

TEST(Gateway, KnowsWhetherItIsWokenInTime) {
  MachineRig rig;
  gateway::Gateway& gateway = rig.harness.gateway();
  EXPECT_TRUE(gateway.meets_deadlines(rig.now() + 1h));  // there is none
  rig.connect(1);
  rig.receive(1, read_request(1));
  EXPECT_TRUE(gateway.meets_deadlines(rig.now()));
  EXPECT_TRUE(gateway.meets_deadlines(rig.now() + 1s));
  EXPECT_FALSE(gateway.meets_deadlines(rig.now() + 2s));
}

TEST(Gateway, ListensBeforeItTransmitsAfterOpening) {
  Settings settings = one_bus();
  settings.buses[0]
      .listen_first.reset();  // the longest response timeout, 100 ms, and its quarantine
  MachineRig rig(settings, false);
  rig.connect(1);
  rig.receive(1, kRead);
  rig.open_line();
  rig.advance(199ms);
  rig.respond("01 03 02 BA AD");  // a late answer to an earlier process
  EXPECT_THAT(rig.take_transmitted(), IsEmpty());
  rig.advance(3ms);
  EXPECT_THAT(rig.take_transmitted(), SizeIs(1));
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
}

TEST(Gateway, OneBusDoesNotDelayAnother) {
  Settings settings = one_bus();
  settings.buses.push_back(settings.buses[0]);
  settings.routes[0].last_unit = 10;
  settings.routes.push_back(settings.routes[0]);
  settings.routes[1].first_unit = settings.routes[1].first_address = 11;
  settings.routes[1].last_unit = 20;
  settings.routes[1].buses = {BusId{1}};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, kRead);
  rig.receive(1, "0002 0000 0006 0B 03 0000 0001");
  rig.respond("0B 03 02 00 07", 1);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 05 0B 03 02 00 07"));
}

TEST(Gateway, StopsInOrder) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, std::string(kRead) + kRead2);
  rig.shutdown();
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 01 83 06"));
  EXPECT_FALSE(rig.finished);
  rig.receive(1, "0003 0000 0006 01 03 0000 0001");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 03 00 00 00 03 01 83 06"));
  rig.respond("01 03 02 00 01");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 05 01 03 02 00 01"));
  EXPECT_TRUE(rig.finished);
}

TEST(Gateway, GivesWhatIsStillUnansweredOnTheWire0BWhenItStops) {
  Settings settings = one_bus();
  settings.buses[0].timing.response_timeout = 10s;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, kRead);
  rig.shutdown();
  rig.advance(1499ms);
  EXPECT_FALSE(rig.finished);
  rig.advance(1ms);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 83 0B"));
  EXPECT_TRUE(rig.finished);
}

TEST(Gateway, AnswersWhatItHasReadAheadWhenItStops) {
  Settings settings = one_bus();
  settings.listeners[0].pipeline = 1;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, std::string(kRead) + kRead2 + "0003 0000 0006 01 03 0000 0001");
  rig.shutdown();
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 02 00 00 00 03 01 83 06", "00 03 00 00 00 03 01 83 06"));
  EXPECT_FALSE(rig.finished);
}

}  // namespace
}  // namespace mbgate::test::lines_test
