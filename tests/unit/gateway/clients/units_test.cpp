// SPDX-License-Identifier: Apache-2.0
// What the unit of a request means: passed on as it is, a device in the place of a broadcast, or
// nothing that is routed.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;

TEST(Units, PassATransparentListenerUnchanged) {
  Settings settings = one_bus();
  settings.routes.clear();
  settings.listeners[0].bus = BusId{0};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 F7 03 0000 0001");
  EXPECT_EQ(rig.take_transmitted().size(), 1U);
  rig.respond("F7 03 02 00 05");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 05 F7 03 02 00 05"));
  rig.receive(1, "0002 0000 0006 F8 03 0000 0001 0003 0000 0006 00 06 0000 0001");
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 02 00 00 00 03 F8 83 0A", "00 03 00 00 00 03 00 86 0A"));
}

/// Some clients can only say unit 0.
TEST(UnitZero, OfARouteThatNamesADeviceIsNoBroadcast) {
  for (const std::uint8_t address : {std::uint8_t{7}, std::uint8_t{0}}) {
    Settings settings = one_bus();
    auto& device = settings.devices.emplace_back();
    device.name = "axis-x";
    device.address = address;
    auto& route = settings.routes.emplace_back();
    route.buses = {BusId{0}};
    route.device = 0;
    route.first_address = address;
    if (address == 0) {
      settings.buses[0].line.framing = bus::Framing::tcp;
      settings.buses[0].line.remote = bus::Endpoint{"far", 502};
    }
    MachineRig rig(settings);
    rig.connect(1);
    rig.receive(1, read_request(1, 0));
    if (address == 0) {
      EXPECT_THAT(rig.take_transmitted(), ElementsAre("00 01 00 00 00 06 00 03 00 00 00 01"));
      rig.line("00 01 00 00 00 05 00 03 02 00 01");
    } else {
      EXPECT_THAT(rig.take_transmitted(), ElementsAre(testing::StartsWith("07 03 00 00 00 01")));
      rig.respond("07 03 02 00 01");
    }
    EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 05 00 03 02 00 01"));
  }
}

Settings routed(const std::vector<std::pair<unsigned, unsigned>>& units) {
  Settings settings = one_bus();
  settings.routes.clear();
  for (const auto& [first, last] : units) {
    auto& route = settings.routes.emplace_back();
    route.first_unit = route.first_address = static_cast<std::uint8_t>(first);
    route.last_unit = static_cast<std::uint8_t>(last);
    route.buses = {BusId{0}};
  }
  return settings;
}

TEST(UnitWithoutARoute, IsJournaledOnceAClient) {
  MachineRig rig(routed({{11, 11}, {12, 12}}));
  rig.connect(1);
  rig.receive(1, read_request(1, 1) + read_request(2, 2) + "0003 0000 0006 FF 04 0000 0001");
  rig.connect(2);  // of the same address
  rig.receive(2, write_request(1, 1));
  EXPECT_THAT(rig.events,
              ElementsAre("listener plant: client 192.0.2.1 asks for unit 1; routed are "
                          "11, 12"));
  rig.connect(3, "192.0.2.2");
  rig.receive(3, read_request(1, 0));
  EXPECT_THAT(rig.events, testing::SizeIs(2));
  rig.reload(routed({{11, 11}}));
  rig.receive(1, read_request(4, 12));
  EXPECT_THAT(rig.events.back(), "listener plant: client 192.0.2.1 asks for unit 12; routed is 11");
}

TEST(UnitWithoutARoute, IsJournaledWithRanges) {
  const auto line = [](const std::vector<std::pair<unsigned, unsigned>>& units) {
    MachineRig rig(routed(units));
    rig.connect(1);
    rig.receive(1, read_request(1, 250));
    return rig.events.empty() ? "" : rig.events.front().substr(rig.events.front().find(';'));
  };
  EXPECT_EQ(line({{1, 32}}), "; routed are 1-32");
  EXPECT_EQ(line({{0, 0}, {7, 7}}), "; routed are 0, 7");
  EXPECT_EQ(line({{1, 32}, {40, 41}, {42, 42}, {247, 247}}), "; routed are 1-32, 40-42, 247");
  EXPECT_EQ(line({}), "; no unit is routed");
  std::vector<std::pair<unsigned, unsigned>> every_second;
  for (unsigned unit = 1; unit < 100; unit += 2) {
    every_second.emplace_back(unit, unit);
  }
  EXPECT_EQ(line(every_second), "; routed are 1, 3, 5, 7, 9, 11, 13, 15, ...");
}

TEST(UnitWithoutARoute, IsJournaledForSoManyClientsOnly) {
  MachineRig rig(routed({{11, 11}}));
  for (unsigned client = 0; client < 300; ++client) {
    rig.connect(client + 1,
                "10.0." + std::to_string(client / 200) + "." + std::to_string(client % 200));
    rig.receive(client + 1, read_request(1, 1));
    rig.disconnect(client + 1);
  }
  EXPECT_THAT(rig.events, testing::SizeIs(256));
}

}  // namespace
}  // namespace mbgate::test
