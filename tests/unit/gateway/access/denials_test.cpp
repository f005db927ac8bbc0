// SPDX-License-Identifier: Apache-2.0
// What the journal is told of requests that their clients may not make, whatever denies them.
#include <gmock/gmock.h>

#include "unit/gateway/access/access_plant.hpp"

namespace mbgate::test {
namespace {

using gateway::WriterRule;
using routing::ClientRole;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

constexpr std::string_view kMany = "0002 0000 0011 01 10 0064 0005 0A 0001 0002 0003 0004 0005 ";
constexpr std::string_view kDeniedClear = "0002 0000 0006 FF 08 000A 0000 ";
const std::string kAsking = "listener plant: client 192.0.2.1";

Settings read_only() {
  Settings settings = stop_plant(16);
  settings.listeners[0].read_only = {*routing::Network::parse("192.0.2.0/24")};
  return settings;
}

Lines told(const Settings& settings, std::string_view request) {
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, request);
  return rig.events;
}

TEST(Denials, NameTheRegistersAndTheValues) {
  EXPECT_THAT(told(read_only(), kMany),
              ElementsAre(kAsking + ": function 16 at unit 1, holding registers 100..104 = 1 2 3 4 "
                                    "5, denied by read_only of listener plant"));
}

// Function 8 is a write in every rule, and has no registers.
TEST(Denials, AreToldOfABroadcastThatIsNone) {
  Settings settings = stop_plant(16);
  settings.routes.emplace_back().buses = {BusId{0}};
  for (const auto* request :
       {"0002 0000 0006 00 08 0001 0000", "0002 0000 0004 00 41 0001",
        "0002 0000 0006 00 03 0000 0001", "0002 0000 0002 00 07", "0002 0000 0005 00 2B 0E 01 00",
        "0002 0000 0008 00 16 0000 0001 0002", "0002 0000 0004 00 18 0001",
        "0002 0000 000D 00 17 0000 0001 0000 0001 02 0001"}) {
    MachineRig rig(settings);
    rig.connect(1);
    rig.receive(1, request);
    EXPECT_THAT(rig.take_sent(1), ElementsAre(testing::EndsWith(" 01"))) << request;
    EXPECT_THAT(rig.events, SizeIs(1)) << request;
    EXPECT_THAT(rig.take_transmitted(), IsEmpty()) << request;
  }
}

TEST(Denials, AreToldWhateverDeniesThem) {
  const std::string write = kAsking + ": function 6 at unit 1, holding register 0 = 1, denied by ";
  Settings settings = stop_plant(16);
  settings.routes[0].access = routing::Access::read_only;
  EXPECT_THAT(told(settings, write_request(2)),
              ElementsAre(write + "access of the route of unit 1"));
  settings = stop_plant(16);
  settings.routes[0].functions.allowed.reset(6).reset(3);
  EXPECT_THAT(told(settings, write_request(2)),
              ElementsAre(write + "functions of the route of unit 1"));
  EXPECT_THAT(told(settings, read_request(2)),
              ElementsAre(kAsking + ": function 3 at unit 1, reads holding register 0, denied by "
                                    "functions of the route of unit 1"));
  settings = stop_plant(16);
  settings.routes[0].windows = {
      {modbus::Table::holding_registers, 5, 1, modbus::Table::holding_registers, 5}};
  EXPECT_THAT(told(settings, write_request(2)),
              ElementsAre(write + "the windows (registers) of the route of unit 1"));
  EXPECT_THAT(told(settings, read_request(2)), IsEmpty());
  settings = stop_plant(16);
  settings.guards.resize(1);
  settings.guards[0].writer = WriterRule::listed;
  EXPECT_THAT(told(settings, write_request(2)), ElementsAre(write + "writer of device axis-x"));
}

TEST(Denials, OfAnotherWriterAreToldToo) {
  Settings settings = stop_plant(16);
  settings.guards.resize(1);
  settings.guards[0].writer = WriterRule::first;
  MachineRig rig(settings);
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  rig.receive(1, write_request(1));
  rig.receive(2, write_request(2));
  EXPECT_THAT(rig.take_sent(2), ElementsAre(busy(2)));
  EXPECT_THAT(rig.events, ElementsAre("listener plant: client 192.0.2.2: function 6 at unit 1, "
                                      "holding register 0 = 1, denied by writer: another client "
                                      "writes now"));
}

TEST(Denials, AreNotWhatCannotBeDoneOrIsWrong) {
  const Settings settings = stop_plant(16);
  EXPECT_THAT(told(settings, "0002 0000 0003 01 06 00 "), IsEmpty());  // cut
  EXPECT_THAT(told(settings, "0002 0000 0003 01 86 00 "), IsEmpty());
  MachineRig rig(settings);
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  rig.receive(2, stop_request(1));
  rig.receive(1, write_request(2) + write_request(3));
  rig.shutdown();
  rig.receive(1, write_request(4));
  EXPECT_THAT(rig.events, IsEmpty());
}

TEST(Denials, SayWhoByTheCertificate) {
  AccessRule reads = reading();
  reads.any_role = true;
  MachineRig rig(plant_with({reads}));
  rig.connect(1, "192.0.2.1", 0, {}, {ClientRole::Kind::named, "viewer", "panel 3"});
  rig.events.clear();
  rig.receive(1, write_request(2));
  EXPECT_THAT(
      rig.events,
      ElementsAre(kAsking +
                  " (role \"viewer\", certificate \"panel 3\"): function 6 at unit 1, holding "
                  "register 0 = 1, denied by the access rules: no "
                  "rule permits it"));
}

TEST(Denials, OfStopsAreToldThoughOthersAreDeniedWithoutEnd) {
  MachineRig rig(read_only());
  rig.connect(1);
  for (unsigned at = 0; at < 100; ++at) {
    rig.receive(1, write_request(at));
  }
  EXPECT_THAT(rig.events, SizeIs(1));
  rig.receive(1, stop_request(100));
  ASSERT_THAT(rig.events, SizeIs(2));
  EXPECT_EQ(rig.events[1], kAsking +
                               ": a stop, function 6 at unit 1, holding register 124 = 225, "
                               "denied by read_only of listener plant");
}

TEST(Denials, OfStopsDoNotFillTheDiskNorHideThoseOfAnotherClient) {
  Settings settings = plant_with({rule_for("192.0.2.0/24")});
  settings.rules[0].access = routing::RuleAccess::read;
  MachineRig rig(settings);
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  for (unsigned at = 0; at < 100; ++at) {
    rig.receive(1, stop_request(at));
  }
  EXPECT_THAT(rig.events, SizeIs(10));
  rig.receive(2, stop_request(1));
  ASSERT_THAT(rig.events, SizeIs(11));
  EXPECT_THAT(rig.events[10], HasSubstr("client 192.0.2.2: a stop, "));
  rig.advance(60s);
  rig.receive(1, stop_request(1));
  EXPECT_THAT(rig.events[11], HasSubstr("; 90 more were denied since the last report"));
}

TEST(Denials, OfClearedCountersAreToldAndTheCountersStay) {
  MachineRig rig(read_only());
  rig.connect(1);
  rig.receive(1, read_request(1));
  rig.respond("01 03 02 00 01");
  rig.take_sent(1);
  rig.receive(1, kDeniedClear);
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 FF 88 01"));
  EXPECT_THAT(rig.events, ElementsAre(kAsking + ": function 8 at unit 255, sub-function 10, denied "
                                                "by read_only of listener plant"));
  EXPECT_EQ(rig.harness.gateway().report_status(0s, rig.now()).counters.requests, 2U);
  Settings settings = plant_with({reading()});
  MachineRig ruled(settings);
  ruled.connect(1);
  ruled.receive(1, kDeniedClear);
  EXPECT_THAT(ruled.take_sent(1), ElementsAre("00 02 00 00 00 03 FF 88 01"));
  EXPECT_THAT(ruled.events, ElementsAre(HasSubstr("denied by the access rules")));
}

}  // namespace
}  // namespace mbgate::test
