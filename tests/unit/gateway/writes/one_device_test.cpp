// SPDX-License-Identifier: Apache-2.0
// A Modbus TCP server that is one drive has 256 names: under whichever it is asked, its stops, the
// order of its requests, its cache and its writers are the same.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"
#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

/// The routed unit 11 leads to the drive; the other listener is transparent.
Settings server(bool every_unit = true) {
  Settings settings = stop_plant(16);
  settings.listeners.emplace_back().name = "service";
  settings.listeners[1].bus = BusId{0};
  settings.buses[0].line.framing = bus::Framing::tcp;
  settings.buses[0].line.remote = bus::Endpoint{"far", 502};
  settings.devices.resize(1);
  settings.devices[0].address = 255;
  settings.devices[0].has_every_unit = every_unit;
  settings.routes[0].first_unit = settings.routes[0].last_unit = 11;
  settings.routes[0].first_address = 255;
  settings.routes[0].device = 0;
  return settings;
}

class OneDevice : public testing::Test {
 protected:
  explicit OneDevice(const Settings& settings = server()) : rig_(settings) {
    rig_.connect(1);
    rig_.connect(2, "192.0.2.2", 1);
  }
  /// Unit and PDU of what went out.
  Lines take() {
    Lines requests;
    for (const auto& adu : rig_.take_transmitted()) {
      requests.push_back(adu.substr(std::string("00 01 00 00 00 06 ").size()));
    }
    return requests;
  }
  MachineRig rig_;
};

TEST_F(OneDevice, AStopCancelsAFeedOfAnotherName) {
  rig_.receive(2, read_request(1, 1));
  EXPECT_THAT(take(), ElementsAre("01 03 00 00 00 01"));
  rig_.receive(1, write_request(2, 11));
  rig_.receive(2, stop_request(3, 5));
  EXPECT_THAT(rig_.take_sent(1), ElementsAre(busy(2, 11)));
  rig_.line("00 01 00 00 00 05 01 03 02 00 01");
  rig_.advance(10ms);
  EXPECT_THAT(take(), ElementsAre("05 06 00 7C 00 E1")) << "the unit is what its client says";
  rig_.line("00 02 00 00 00 06 05 06 00 7C 00 E1");
  rig_.advance(10ms);
  EXPECT_THAT(take(), IsEmpty());
}

TEST_F(OneDevice, HasOneOrderOfItsRequests) {
  Settings settings = server();
  settings.buses[0].outstanding = 4;
  rig_.reload(settings);
  rig_.receive(1, write_request(1, 11));
  rig_.receive(2, write_request(2, 3));
  EXPECT_THAT(take(), ElementsAre("FF 06 00 00 00 01"));
  rig_.line("00 01 00 00 00 06 FF 06 00 00 00 01");
  rig_.advance(1ms);
  EXPECT_THAT(take(), ElementsAre("03 06 00 00 00 01"));
}

TEST_F(OneDevice, ForgetsWhatWasReadBeforeAWriteOfAnotherName) {
  Settings settings = server();
  settings.devices[0].cache = 1s;
  rig_.reload(settings);
  rig_.receive(1, read_request(1, 11));
  EXPECT_THAT(take(), ElementsAre("FF 03 00 00 00 01"));
  rig_.line("00 01 00 00 00 05 FF 03 02 00 07");
  rig_.receive(1, read_request(2, 11));
  EXPECT_THAT(take(), IsEmpty());
  rig_.receive(2, write_request(3, 9));
  rig_.line("00 02 00 00 00 06 09 06 00 00 00 01");
  rig_.advance(1ms);
  take();
  rig_.receive(1, read_request(4, 11));
  EXPECT_THAT(take(), ElementsAre("FF 03 00 00 00 01"));
}

/// Where it was no drive but a gateway to several, nobody gets another one's values.
TEST_F(OneDevice, SharesNoReadWithAnotherUnit) {
  Settings settings = server();
  settings.buses[0].coalesce = true;
  rig_.reload(settings);
  rig_.receive(2, read_request(1, 1));
  rig_.receive(2, read_request(2, 2) + read_request(4, 2) + read_request(3, 3));
  rig_.line("00 01 00 00 00 05 01 03 02 00 01");
  rig_.line("00 02 00 00 00 05 02 03 02 00 02");
  rig_.line("00 03 00 00 00 05 03 03 02 00 03");
  EXPECT_THAT(take(), ElementsAre("01 03 00 00 00 01", "02 03 00 00 00 01", "03 03 00 00 00 01"));
  EXPECT_THAT(rig_.take_sent(2), testing::UnorderedElementsAre("00 01 00 00 00 05 01 03 02 00 01",
                                                               "00 02 00 00 00 05 02 03 02 00 02",
                                                               "00 03 00 00 00 05 03 03 02 00 03",
                                                               "00 04 00 00 00 05 02 03 02 00 02"));
}

TEST_F(OneDevice, SharesNoStopWithAnotherUnit) {
  rig_.receive(1, read_request(1, 11));
  rig_.receive(2, stop_request(1, 1) + stop_request(2, 2) + stop_request(3, 3));
  rig_.line("00 01 00 00 00 05 FF 03 02 00 07");
  Lines stops;
  for (const char unit : {'1', '2', '3'}) {
    const Lines sent = take();
    stops.insert(stops.end(), sent.begin(), sent.end());
    const char transaction = static_cast<char>(unit + 1);
    rig_.line(std::string("00 0") + transaction + " 00 00 00 06 0" + unit + " 06 00 7C 00 E1");
    rig_.advance(1ms);
  }
  EXPECT_THAT(stops, testing::IsSupersetOf(
                         {"01 06 00 7C 00 E1", "02 06 00 7C 00 E1", "03 06 00 7C 00 E1"}));
}

TEST_F(OneDevice, HasItsWritersUnderEachName) {
  Settings settings = server();
  settings.guards.resize(1);
  settings.guards[0].writer = gateway::WriterRule::first;
  rig_.reload(settings);
  rig_.receive(1, write_request(1, 11));
  rig_.receive(2, write_request(2, 3));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre(busy(2, 3)));
}

TEST_F(OneDevice, ChecksTheUnitThatWasAskedFor) {
  Settings settings = server();
  settings.buses[0].check_unit = true;
  rig_.reload(settings);
  rig_.receive(2, read_request(1, 3));
  rig_.line("00 01 00 00 00 05 FF 03 02 00 07");
  EXPECT_THAT(rig_.take_sent(2), IsEmpty());
  rig_.line("00 01 00 00 00 05 03 03 02 00 07");
  EXPECT_THAT(rig_.take_sent(2), ElementsAre("00 01 00 00 00 05 03 03 02 00 07"));
}

class SeveralDevices : public OneDevice {
 protected:
  SeveralDevices() : OneDevice(server(false)) {}
};

TEST_F(SeveralDevices, AreEachAUnit) {
  rig_.receive(2, read_request(1, 1));
  rig_.receive(1, write_request(2, 11));
  rig_.receive(2, stop_request(3, 5));
  EXPECT_THAT(rig_.take_sent(1), IsEmpty());
}

/// It rests before its next try, the server closes, and the bus is given up.
TEST_F(OneDevice, AStopThatWasRefusedEndsWithItsLine) {
  rig_.receive(1, stop_request(1, 11));
  rig_.line("00 01 00 00 00 03 FF 86 06");
  rig_.close_line();
  Settings settings = server();
  settings.buses[0].name = "line-b";
  settings.buses[0].line.remote = bus::Endpoint{"elsewhere", 502};
  rig_.reload(settings);
  EXPECT_THAT(rig_.take_sent(1), ElementsAre("00 01 00 00 00 03 0B 86 0B"));
  rig_.shutdown();
  EXPECT_TRUE(rig_.finished);
}

/// From one identity to the other: a unit that led to the drive does so no more.
TEST_F(OneDevice, AReloadThatSaysOtherwiseEndsWhatWaits) {
  rig_.receive(2, read_request(1, 1));
  take();
  rig_.receive(2, write_request(2, 3));
  rig_.reload(server(false));
  EXPECT_THAT(rig_.take_sent(2), ElementsAre(busy(2, 3)));
}

}  // namespace
}  // namespace mbgate::test
