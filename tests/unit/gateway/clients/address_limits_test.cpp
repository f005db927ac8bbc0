// SPDX-License-Identifier: Apache-2.0
// How many connections one client address may have, and how often new ones.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

TEST(AddressLimits, TheIdlestConnectionOfTheSameAddressMakesRoom) {
  Settings settings = one_bus();
  settings.listeners[0].max_connections_per_address = 2;
  MachineRig rig(settings);
  rig.connect(1, "192.0.2.9");
  rig.advance(1s);
  rig.connect(2, "192.0.2.1");
  rig.advance(1s);
  rig.connect(3, "192.0.2.1");
  rig.connect(4, "192.0.2.1");
  EXPECT_THAT(rig.closed, ElementsAre(2));
  EXPECT_THAT(
      rig.events,
      ElementsAre(
          "listener plant: client 192.0.2.1 closed for a newer connection of the same client: "
          "max_connections_per_address (2) is reached"));
}

TEST(AddressLimits, WhereNoneIsIdleTheNewConnectionIsRefused) {
  Settings settings = one_bus();
  settings.listeners[0].max_connections_per_address = 1;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.connect(2);
  rig.connect(3, "192.0.2.3");
  EXPECT_THAT(rig.closed, ElementsAre(2));
  EXPECT_THAT(rig.events, ElementsAre("listener plant: client 192.0.2.1 refused: "
                                      "max_connections_per_address is reached and none of these "
                                      "connections is idle"));
  rig.disconnect(1);
  rig.connect(4);
  EXPECT_THAT(rig.closed, ElementsAre(2));
}

TEST(AddressLimits, OfAListenerDoNotCountThoseOfAnother) {
  Settings settings = one_bus();
  settings.listeners.emplace_back().name = "service";
  settings.listeners[0].max_connections_per_address = 1;
  settings.listeners[1].max_connections_per_address = 1;
  MachineRig rig(settings);
  rig.connect(1);
  rig.connect(2, "192.0.2.1", 1);
  EXPECT_THAT(rig.closed, IsEmpty());
}

TEST(AddressLimits, MoreThanSoManyNewConnectionsASecondAreRefused) {
  Settings settings = one_bus();
  settings.listeners[0].max_connects_per_second = 4;
  MachineRig rig(settings);
  for (std::uint64_t client = 1; client <= 5; ++client) {
    rig.connect(client);
    rig.disconnect(client);  // to close them is no help
  }
  rig.connect(6, "192.0.2.6");
  EXPECT_THAT(rig.closed, ElementsAre(5));
  EXPECT_THAT(
      rig.events,
      ElementsAre("listener plant: client 192.0.2.1 refused: more than max_connects_per_second"));
  rig.advance(249ms);
  rig.connect(7);
  rig.advance(1ms);
  rig.connect(8);
  rig.connect(9);
  EXPECT_THAT(rig.closed, ElementsAre(5, 7, 9));
}

TEST(AddressLimits, AfterASecondOfPauseAsManyMayComeAtOnceAgain) {
  Settings settings = one_bus();
  settings.listeners[0].max_connects_per_second = 2;
  MachineRig rig(settings);
  rig.connect(1);
  rig.connect(2);
  rig.disconnect(1);
  rig.disconnect(2);
  rig.advance(1s);
  rig.connect(3);
  rig.connect(4);
  rig.connect(5);
  EXPECT_THAT(rig.closed, ElementsAre(5));
}

TEST(AddressLimits, AreOffWhereTheyAreZero) {
  Settings settings = one_bus();
  settings.listeners[0].max_connects_per_second = 0;
  settings.listeners[0].max_requests_per_second = 0;
  MachineRig rig(settings);
  for (std::uint64_t client = 1; client <= 500; ++client) {
    rig.connect(client);
    rig.receive(client, read_request(1, 250));  // has no route, so its answer comes at once
    EXPECT_THAT(rig.take_sent(client), SizeIs(1));
    rig.disconnect(client);
  }
  EXPECT_THAT(rig.closed, IsEmpty());
}

}  // namespace
}  // namespace mbgate::test
