// SPDX-License-Identifier: Apache-2.0
// How far a stop reaches: back to what lay in sockets, to every device that hears it, and no
// further than this process.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

TEST(Stop, TakesBackWhatLayInAPausedSocketButNotItsOwnClientsLaterWrites) {
  MachineRig rig(stop_plant());
  rig.confirms = false;
  std::string many;
  for (unsigned transaction = 0; transaction < 64; ++transaction) {
    many += read_request(transaction, 250);  // no such path: answered at once
  }
  for (const std::uint64_t client : {1U, 2U}) {
    rig.connect(client);
    rig.receive(client, many);
    ASSERT_TRUE(rig.paused.contains(client));
  }
  rig.advance(40ms);
  rig.confirms = true;
  for (int answers = 0; answers < 64; ++answers) {
    rig.confirm_sent(1);
    rig.confirm_sent(2);
  }
  rig.take_sent(1);
  rig.take_sent(2);
  rig.receive(1, stop_request(201) + write_request(202));
  rig.receive(2, write_request(203));
  EXPECT_THAT(rig.take_sent(2), ElementsAre(busy(203)));
  rig.respond(kStop1);
  rig.advance(100ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1, kWrite1));
}

TEST(Stop, IsSentThoughItIsOlderThanTheProcess) {
  MachineRig rig(stop_plant());
  rig.connect(1, "192.0.2.1", 0, Instant::min());
  rig.receive(1, write_request(1) + stop_request(2));
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
  rig.respond(kStop1);
  EXPECT_THAT(rig.take_sent(1), ElementsAre(busy(1), written(2, 1, true)));
}

TEST(Stop, IsSentThoughItsClientHadGoneBeforeItWasRead) {
  MachineRig rig(stop_plant());
  rig.connect(1);
  rig.disconnect(1, write_request(1) + stop_request(2));
  EXPECT_THAT(take_requests(rig), ElementsAre(kStop1));
  rig.respond(kStop1);
  rig.advance(10s);
  EXPECT_THAT(take_requests(rig), IsEmpty());
}

TEST(Stop, OfAllCountsForEveryDeviceThatHearsIt) {
  Settings settings = stop_plant();
  settings.devices[1].profile.broadcast.form = std::nullopt;
  auto& route = settings.routes.emplace_back();
  route.buses = {BusId{0}};  // unit 0
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.receive(1, write_request(2, 1) + write_request(3, 2) + stop_request(4, 0));
  rig.respond("01 03 02 00 01");
  rig.advance(150ms);
  EXPECT_THAT(take_requests(rig), ElementsAre(kRead1, "00 06 00 7C 00 E1", kWrite2));
  EXPECT_THAT(rig.take_sent(1), ElementsAre(kOne, "00 04 00 00 00 06 00 06 00 7C 00 E1", busy(2)));
  EXPECT_THAT(rig.events, ElementsAre(testing::HasSubstr("stops by broadcast, but not devices "
                                                         "axis-y")));
}

/// Unit 0 leads to both lines: a stop for axis-x on the first, for axis-z on the second a write
/// like others.
Settings half_stopped() {
  Settings settings = stop_plant();
  settings.buses.push_back(settings.buses[0]);
  settings.buses[1].name = "line-b";
  settings.devices.push_back(stoppable("axis-z", 11));
  settings.devices[2].bus = BusId{1};
  settings.devices[2].profile.stops.clear();
  settings.guards.resize(3);
  settings.routes.emplace_back().buses = {BusId{0}, BusId{1}};  // unit 0
  auto& route = settings.routes.emplace_back();
  route.first_unit = route.last_unit = route.first_address = 11;
  route.buses = {BusId{1}};
  settings.routes[0].last_unit = 10;
  return settings;
}

constexpr auto kStopAll = "00 06 00 7C 00 E1";

TEST(StopOnOneLine, IsSentOnAllWhoeverMayWriteThere) {
  Settings settings = half_stopped();
  settings.guards[2].writer = gateway::WriterRule::listed;
  settings.guards[2].writers = {*routing::Network::parse("192.0.2.9")};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, stop_request(4, 0));
  rig.advance(150ms);
  EXPECT_THAT(take_requests(rig, 0), ElementsAre(kStopAll));
  EXPECT_THAT(take_requests(rig, 1), ElementsAre(kStopAll));
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 04 00 00 00 06 00 06 00 7C 00 E1"));
}

TEST(StopOnOneLine, DoesNotGoForAClientThatHasGoneOnTheNext) {
  MachineRig rig(half_stopped());
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  rig.receive(2, read_request(1, 11));
  rig.receive(1, stop_request(4, 0));
  rig.disconnect(1);
  rig.respond("0B 03 02 00 01", 1);
  rig.advance(150ms);
  EXPECT_THAT(take_requests(rig, 0), ElementsAre(kStopAll));
  EXPECT_THAT(take_requests(rig, 1), ElementsAre("0B 03 00 00 00 01"));
}

TEST(StopOnOneLine, OfWhichTheOtherIsLostWhileTheGatewayStopsHadNoPath) {
  Settings settings = half_stopped();
  settings.devices[2].profile.stops = settings.devices[0].profile.stops;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.shutdown();
  rig.lose_line(1);
  rig.receive(1, stop_request(4, 0) + stop_request(5, 11));
  rig.respond("01 03 02 00 01");
  rig.advance(150ms);
  EXPECT_THAT(take_requests(rig, 0), ElementsAre(kRead1, kStopAll));
  EXPECT_THAT(take_requests(rig, 1), IsEmpty());
  EXPECT_THAT(rig.take_sent(1), testing::UnorderedElementsAre(kOne, "00 04 00 00 00 03 00 86 0A",
                                                              "00 05 00 00 00 03 0B 86 0A"));
}

}  // namespace
}  // namespace mbgate::test
