// SPDX-License-Identifier: Apache-2.0
// Other settings while a drive is asked for its word order, or a stop is under way.
#include <gmock/gmock.h>

#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using testing::ElementsAre;

// Its first device is asked for its word order before values are written.
Settings asking_plant() {
  Settings settings = stop_plant(16);
  auto& device = settings.devices[0];
  device.word_order = drive::WordOrder::little;
  device.verify_word_order = true;
  device.profile.values.add({modbus::Table::holding_registers, 30});
  device.profile.word_order_register = drive::WordOrderRegister{9, {5}, {133}};
  settings.routes[0].last_unit = 1;
  settings.routes[0].device = 0;
  settings.routes[0].word_order = drive::WordOrder::big;
  return settings;
}

TEST(ReloadOfDrives, LetsRequestsEndByTheSettingsTheyBeganWith) {
  const Settings settings = asking_plant();
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 000B 01 10 001E 0002 04 0001 0002");
  EXPECT_THAT(take_requests(rig), ElementsAre("01 03 00 09 00 01"));
  for (int times = 0; times < 3; ++times) {
    rig.reload(settings);
  }
  rig.respond("01 03 02 00 85");
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre("01 10 00 1E 00 02 04 00 02 00 01"));
  rig.respond("01 10 00 1E 00 02");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 06 01 10 00 1E 00 02"));
}

// The drive has not the order that it is said to have now: nothing is written in that.
TEST(ReloadOfDrives, AsksAgainThoughAQuestionOfBeforeIsAnswered) {
  Settings settings = asking_plant();
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 000B 01 10 001E 0002 04 0001 0002");
  take_requests(rig);
  settings.devices[0].word_order = drive::WordOrder::big;
  rig.reload(settings);
  rig.respond("01 03 02 00 85");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 90 06"));
  rig.receive(1, "0002 0000 000B 01 10 001E 0002 04 0001 0002");
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre("01 03 00 09 00 01"));
  rig.respond("01 03 02 00 85");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 03 01 90 04"));
}

// The drive tells its order in another register now, which may hold something else.
TEST(ReloadOfDrives, AsksAgainThoughTheRegisterOfBeforeHeldTheOrder) {
  Settings settings = asking_plant();
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 000B 01 10 001E 0002 04 0001 0002");
  take_requests(rig);
  settings.devices[0].profile.word_order_register->address = 10;
  rig.reload(settings);
  rig.respond("01 03 02 00 85");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 03 01 90 06"));
  rig.receive(1, "0002 0000 000B 01 10 001E 0002 04 0001 0002");
  rig.advance(10ms);
  EXPECT_THAT(take_requests(rig), ElementsAre("01 03 00 0A 00 01"));
}

// The drive is still where it was.
TEST(ReloadOfLines, RepeatsAStopAtAnotherRateButNotOnAnotherPort) {
  for (const char* device : {"/dev/ttyS0", "/dev/ttyS7"}) {
    Settings settings = stop_plant();
    settings.buses[0].line.device = "/dev/ttyS0";
    MachineRig rig(settings);
    rig.connect(1);
    rig.receive(1, read_request(1) + stop_request(2));
    take_requests(rig);
    settings.buses[0].line.baud = modbus::Baud{9600};
    settings.buses[0].line.device = device;
    rig.reload(settings);
    rig.open_line(0);
    rig.advance(10ms);
    const bool is_same = settings.buses[0].line.device == "/dev/ttyS0";
    EXPECT_EQ(take_requests(rig), is_same ? Lines{kStop1} : Lines{}) << device;
    rig.respond(kStop1, 0);
    EXPECT_THAT(rig.take_sent(1),
                testing::Contains(is_same ? written(2, 1, true) : "00 02 00 00 00 03 01 86 0B"));
  }
}

TEST(ReloadOfLines, GoesOnWithAStopOfABusThatGetsAnotherName) {
  Settings settings = stop_plant();
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, stop_request(1));
  EXPECT_EQ(take_requests(rig), Lines{kStop1});
  settings.buses[0].name = "line";
  rig.reload(settings);
  rig.open_line(1);
  rig.advance(10ms);
  EXPECT_EQ(take_requests(rig, 1), Lines{kStop1});
  rig.respond(kStop1, 1);
  EXPECT_THAT(rig.take_sent(1), testing::Contains(written(1, 1, true)));
}

}  // namespace
}  // namespace mbgate::test
