// SPDX-License-Identifier: Apache-2.0
// Other settings while the gateway runs: what did not change goes on as if nothing had happened.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// Bus line-a with axis-x (1) and axis-y (2), bus line-b with axis-z (unit and address 11).
Settings plant() {
  Settings settings = stop_plant(16);
  settings.routes[0].last_unit = 10;
  settings.buses.push_back(settings.buses[0]);
  settings.buses[1].name = "line-b";
  settings.buses[1].line.device = "/dev/ttyS1";
  settings.devices.push_back(stoppable("axis-z", 11));
  settings.devices[2].bus = BusId{1};
  settings.routes.push_back(settings.routes[0]);
  settings.routes[1].first_unit = settings.routes[1].first_address = 11;
  settings.routes[1].last_unit = 20;
  settings.routes[1].buses = {BusId{1}};
  return settings;
}

/// The same plant with its buses, and so their numbers, the other way round.
Settings turned() {
  Settings settings = plant();
  std::swap(settings.buses[0], settings.buses[1]);
  std::swap(settings.routes[0].buses, settings.routes[1].buses);
  for (auto& device : settings.devices) {
    device.bus = BusId{1U - static_cast<std::uint32_t>(device.bus)};
  }
  return settings;
}

class Reload : public testing::Test {
 protected:
  Reload() {
    rig_.connect(1);
    rig_.receive(1, read_request(1));
    rig_.receive(1, write_request(2) + write_request(3, 2));
    rig_.receive(1, read_request(4, 11));
    rig_.receive(1, write_request(5, 11));
    EXPECT_THAT(take_requests(rig_), ElementsAre(kRead1));
    EXPECT_THAT(take_requests(rig_, 1), ElementsAre("0B 03 00 00 00 01"));
    rig_.advance(10ms);
  }
  MachineRig rig_{plant()};
};

constexpr auto kFour = "00 04 00 00 00 05 0B 03 02 00 01";

TEST_F(Reload, ChangesNothingIfNothingChanged) {
  rig_.reload(plant());
  EXPECT_THAT(rig_.take_sent(1), IsEmpty());
  EXPECT_THAT(rig_.opened, IsEmpty());
  EXPECT_EQ(rig_.shut, 0U);
  rig_.respond("01 03 02 00 01");
  rig_.advance(10ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kOne));
  EXPECT_THAT(take_requests(rig_), SizeIs(1));
}

TEST_F(Reload, LeavesBusesTheirNumbersWhateverTheirOrder) {
  rig_.reload(turned());
  EXPECT_THAT(rig_.opened, IsEmpty());
  rig_.respond("01 03 02 00 01", 0);
  rig_.respond("0B 03 02 00 01", 1);
  rig_.advance(10ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kOne, kFour));
  EXPECT_THAT(take_requests(rig_, 1), ElementsAre("0B 06 00 00 00 01"));
  EXPECT_THAT(take_requests(rig_, 0), ElementsAre(kWrite1));
  rig_.respond(kWrite1, 0);
  rig_.advance(10ms);
  EXPECT_THAT(take_requests(rig_, 0), ElementsAre(kWrite2));
  rig_.disconnect(1);
  rig_.lose_line(0);
  EXPECT_THAT(rig_.events, ElementsAre("bus line-a is lost; it is being reopened"));
}

TEST_F(Reload, OpensAChangedLineAnew) {
  Settings changed = turned();
  changed.buses[1].line.baud = modbus::Baud{9600};  // line-a
  rig_.reload(changed);
  EXPECT_THAT(rig_.take_sent(1),
              ElementsAre("00 01 00 00 00 03 01 83 0B", "00 02 00 00 00 03 01 86 0A",
                          "00 03 00 00 00 03 02 86 0A"));
  EXPECT_EQ(rig_.shut, 1U);
  EXPECT_THAT(rig_.opened, SizeIs(1));
  rig_.respond("0B 03 02 00 01", 1);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kFour));
  rig_.open_line(0);
  rig_.advance(300ms);  // the drive may still answer what it was asked over the line before
  rig_.receive(1, read_request(1));
  EXPECT_THAT(take_requests(rig_, 0), ElementsAre(kRead1));
}

TEST_F(Reload, EndsWhatGoesToABusThatIsNoMore) {
  Settings changed = plant();
  changed.buses.erase(changed.buses.begin());
  changed.routes.erase(changed.routes.begin());
  changed.routes[0].buses = {BusId{0}};
  changed.devices.erase(changed.devices.begin(), changed.devices.begin() + 2);
  changed.devices[0].bus = BusId{0};
  rig_.reload(changed);
  EXPECT_THAT(rig_.take_sent(1),
              ElementsAre("00 01 00 00 00 03 01 83 0B", "00 02 00 00 00 03 01 86 0A",
                          "00 03 00 00 00 03 02 86 0A"));
  EXPECT_EQ(rig_.shut, 1U);
  rig_.open_line(0);  // news of a line that is no more
  rig_.respond("01 03 02 00 01", 0);
  rig_.respond("0B 03 02 00 01", 1);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kFour));
  rig_.receive(1, read_request(6));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("00 06 00 00 00 03 01 83 0A"));
  rig_.reload(plant());
  EXPECT_THAT(rig_.opened, SizeIs(1));
}

TEST_F(Reload, ShowsBusesAndDevicesAsTheyAreWrittenDown) {
  rig_.reload(turned());
  rig_.receive(1, "0006 0000 0006 FF 04 2710 0002");  // the first device: axis-x, on the second bus
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("00 06 00 00 00 07 FF 04 04 00 02 00 01"));
  Settings less = turned();
  less.buses.pop_back();
  less.routes.erase(less.routes.begin());
  less.devices.erase(less.devices.begin(), less.devices.begin() + 2);
  rig_.reload(less);
  rig_.take_sent(1);
  rig_.receive(1, "0007 0000 0006 FF 04 0000 0003");
  rig_.receive(1, "0008 0000 0006 FF 04 2710 0002");
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("00 07 00 00 00 09 FF 04 06 00 02 00 01 00 01",
                                             "00 08 00 00 00 07 FF 04 04 00 01 00 0B"));
}

TEST_F(Reload, ClosesWhoComesFromAListenerThatIsNoMore) {
  Settings changed = plant();
  changed.listeners[0].name = "other";
  rig_.reload(changed);
  rig_.connect(2);
  EXPECT_THAT(rig_.closed, ElementsAre(1, 2));
}

TEST_F(Reload, OpensANewBus) {
  Settings changed = plant();
  changed.buses.push_back(changed.buses[0]);
  changed.buses[2].name = "line-c";
  rig_.reload(changed);
  EXPECT_THAT(rig_.opened, SizeIs(1));
  EXPECT_EQ(rig_.shut, 0U);
}

TEST_F(Reload, TakesBackWhatWaitsForADeviceThatIsAnotherNow) {
  Settings changed = plant();
  changed.devices[0].word_order = drive::WordOrder::big;
  rig_.reload(changed);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(2)));
  rig_.respond("01 03 02 00 01");
  rig_.advance(10ms);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(kOne));
  EXPECT_THAT(take_requests(rig_), ElementsAre(kWrite2));
}

TEST_F(Reload, KnowsADeviceByItsNameAndAddress) {
  Settings changed = plant();
  changed.devices[1].address = 3;
  changed.devices[1].timing.gap = 1ms;
  changed.devices[0].timing.response_timeout = 200ms;  // this is no other device
  rig_.reload(changed);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(3, 2)));
}

TEST_F(Reload, TakesBackWhatWaitsOfAUnitThatLeadsToAnotherDevice) {
  Settings changed = plant();
  changed.routes[0].last_unit = 1;  // unit 2 was axis-y, and its write waits
  auto& route = changed.routes.emplace_back(plant().routes[1]);
  route.first_unit = route.last_unit = 2;
  route.first_address = 11;
  rig_.reload(changed);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(3, 2)));
  rig_.respond("01 03 02 00 01");
  rig_.advance(10ms);
  EXPECT_THAT(take_requests(rig_), ElementsAre(kWrite1));
}

TEST_F(Reload, TakesBackWhatWaitsOfAUnitThatLeadsToAnotherAddressOrNowhere) {
  Settings changed = plant();
  changed.routes[0].first_unit = 2;
  changed.routes[0].first_address = 3;
  rig_.reload(changed);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(2), busy(3, 2)));
  changed.routes.pop_back();
  rig_.reload(changed);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(5, 11)));
}

TEST_F(Reload, TakesBackWhatWaitsOfABroadcastThatLeadsElsewhere) {
  Settings changed = plant();
  changed.routes.emplace_back().buses = {BusId{0}};  // unit 0
  rig_.reload(changed);
  rig_.receive(1, write_request(6, 0));
  EXPECT_THAT(rig_.take_sent(1), IsEmpty());
  changed.routes.back().device = 0;
  changed.routes.back().first_address = 1;
  rig_.reload(changed);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(6, 0)));
}

TEST_F(Reload, TakesBackWhatWaitsOnARouteThatAsksForAnotherWordOrder) {
  Settings changed = plant();
  changed.routes[1].word_order = drive::WordOrder::big;
  rig_.reload(changed);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(5, 11)));
}

TEST_F(Reload, ClosesClientsOfListenersThatAreNoMore) {
  Settings changed = plant();
  changed.listeners[0].name = "other";
  rig_.reload(changed);
  EXPECT_THAT(rig_.closed, ElementsAre(1));
  rig_.respond("01 03 02 00 01");
  rig_.advance(200ms);
  EXPECT_THAT(take_requests(rig_), IsEmpty());
}

TEST_F(Reload, ClosesClientsThatAreNotAllowedAnyMore) {
  Settings changed = plant();
  changed.listeners[0].allow = {*routing::Network::parse("192.0.2.9")};
  rig_.reload(changed);
  EXPECT_THAT(rig_.closed, ElementsAre(1));
  EXPECT_THAT(rig_.events, ElementsAre("listener plant: client 192.0.2.1 refused: not in the allow "
                                       "list"));
}

TEST_F(Reload, GivesClientsTheirNewRights) {
  Settings changed = plant();
  changed.listeners.emplace(changed.listeners.begin())->name = "new";
  changed.listeners[1].read_only = {*routing::Network::parse("192.0.2.1")};
  rig_.reload(changed);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(2), busy(3, 2), busy(5, 11)));
  rig_.receive(1, write_request(6));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("00 06 00 00 00 03 01 86 01"));
}

TEST(ReloadOfGuards, KeepsOwners) {
  Settings settings = stop_plant(16);
  settings.guards.resize(2);
  settings.guards[0].writer = gateway::WriterRule::first;
  MachineRig rig(settings);
  rig.connect(1, "192.0.2.1");
  rig.connect(2, "192.0.2.2");
  rig.receive(1, write_request(1));
  rig.respond(kWrite1);
  rig.advance(10ms);
  rig.take_transmitted();
  std::swap(settings.devices[0], settings.devices[1]);
  std::swap(settings.guards[0], settings.guards[1]);
  rig.reload(settings);
  rig.receive(2, write_request(2));
  EXPECT_THAT(rig.take_sent(2), ElementsAre(busy(2)));
  EXPECT_THAT(take_requests(rig), IsEmpty());
}

TEST(ReloadOfListeners, CanTakeAllOfThemAway) {
  MachineRig rig(plant());
  rig.connect(1);
  rig.receive(1, read_request(1));
  Settings deaf = plant();
  deaf.listeners.clear();
  rig.reload(deaf);
  EXPECT_TRUE(rig.closed.contains(1));
  rig.reload(deaf);  // the read is still on the wire
  rig.reload(plant());
  rig.respond("01 03 02 00 01");
  EXPECT_THAT(rig.take_sent(1), IsEmpty());
}

TEST_F(Reload, ANewIdleTimeoutHoldsForClientsThatAreThere) {
  MachineRig rig;
  rig.connect(1);
  Settings settings = one_bus();
  settings.listeners[0].idle_timeout = 60s;
  rig.reload(settings);
  rig.advance(60s);
  EXPECT_TRUE(rig.closed.contains(1));
}

}  // namespace
}  // namespace mbgate::test
