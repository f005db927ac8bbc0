// SPDX-License-Identifier: Apache-2.0
// Unit 255, which is the gateway itself: its identification, and its health as input registers.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test::status_unit_test {
namespace {

using testing::ElementsAre;
using testing::SizeIs;

constexpr auto kRead = "0001 0000 0006 01 03 0000 0001";

TEST(StatusUnit, IdentifiesItself) {
  MachineRig rig(one_bus(), false);
  rig.connect(1);
  rig.receive(1, "0001 0000 0005 FF 2B 0E 01 00");
  const auto sent = rig.take_sent(1);
  ASSERT_THAT(sent, SizeIs(1));
  // conformity 82, no more follows, three objects, the first "mbgate"
  EXPECT_THAT(sent[0], testing::HasSubstr("FF 2B 0E 01 82 00 00 03 00 06 6D 62 67 61 74 65 01 07"));
  rig.receive(1,
              "0009 0000 0005 FF 2B 0E 01 04");  // not among the basic objects: from the first on
  EXPECT_THAT(rig.take_sent(1), ElementsAre(testing::HasSubstr("FF 2B 0E 01 82 00 00 03 00 06")));
  rig.receive(1, "000C 0000 0005 FF 2B 0E 02 00");  // the regular ones too
  EXPECT_THAT(rig.take_sent(1), ElementsAre(testing::HasSubstr("FF 2B 0E 02 82 00 00 04 00 06")));
  // one object alone, "mbgated"; and those from it on
  rig.receive(1, "000A 0000 0005 FF 2B 0E 04 01");
  EXPECT_THAT(rig.take_sent(1), ElementsAre(testing::EndsWith("FF 2B 0E 04 82 00 00 01 01 07 "
                                                              "6D 62 67 61 74 65 64")));
  rig.receive(1, "000B 0000 0005 FF 2B 0E 03 01");
  EXPECT_THAT(
      rig.take_sent(1),
      ElementsAre(testing::HasSubstr("FF 2B 0E 03 82 00 00 03 01 07 6D 62 67 61 74 65 64 02")));
  rig.receive(1, "0002 0000 0005 FF 2B 0E 04 7F 0003 0000 0005 FF 2B 0E 05 00");
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 02 00 00 00 03 FF AB 02", "00 03 00 00 00 03 FF AB 03"));
}

TEST(StatusUnit, CountsInTwoRegisters) {
  MachineRig rig;
  rig.connect(1);
  rig.advance(65537s);
  rig.receive(1, "0002 0000 0006 FF 04 0004 0002");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 07 FF 04 04 00 01 00 01"));
}

TEST(StatusUnit, CountsWhatIsNoModbusTcp) {
  MachineRig rig;
  rig.connect(1);
  rig.connect(2, "192.0.2.2");
  rig.receive(2, "0001 0007 0002 01 03");  // another protocol
  rig.receive(2, "0002 0007 0002 01 03");
  rig.receive(2, "0003 0000 FFFF 01 03");
  rig.receive(1, "0002 0000 0006 FF 04 0008 0004");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 0B FF 04 08 00 00 00 02 00 00 00 01"));
}

TEST(StatusUnit, ShowsTheHealthOfBusesAndDevices) {
  Settings settings = one_bus();
  settings.devices = {{"axis", BusId{0}, 1, settings.buses[0].timing}};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, kRead);
  rig.advance(10ms);
  rig.respond("01 83 02");
  rig.take_sent(1);
  rig.receive(1, "0002 0000 0006 FF 04 0000 0004");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 0B FF 04 08 00 02 00 01 00 01 00 01"));
  rig.receive(1, "0003 0000 0006 FF 04 03E8 0008");  // bus 0: open, 0 waiting, 1, 1, 1 exception
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 03 00 00 00 13 FF 04 10 00 01 00 00 00 00 00 01 "
                                            "00 00 00 01 00 00 00 01"));
  rig.receive(1, "0004 0000 0006 FF 04 2710 0004");  // device 0: bus 1, address 1, answering
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 04 00 00 00 0B FF 04 08 00 01 00 01 00 01 00 00"));
  rig.receive(1, "0006 0000 0006 FF 04 272F 0001");  // its last register
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 06 00 00 00 05 FF 04 02 00 00"));
  rig.lose_line();
  rig.receive(1, "0007 0000 0006 FF 04 2712 0001");  // device 0: its line is not open
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 07 00 00 00 05 FF 04 02 00 05"));
  rig.receive(1, "0008 0000 0006 FF 04 03E8 0001");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 08 00 00 00 05 FF 04 02 00 00"));
  rig.receive(1, "0005 0000 0006 FF 04 2710 0021");  // there is no second device
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 05 00 00 00 03 FF 84 02"));
}

TEST(StatusUnit, TellsTheJournalWhoReadsAnotherTableOfIt) {
  MachineRig rig;
  rig.connect(1);
  rig.events.clear();
  rig.receive(1, "0001 0000 0006 FF 03 0000 0004 0002 0000 0006 FF 01 0000 0004");
  EXPECT_THAT(rig.take_sent(1),
              ElementsAre("00 01 00 00 00 03 FF 83 01", "00 02 00 00 00 03 FF 81 01"));
  EXPECT_THAT(
      rig.events,
      ElementsAre(
          "listener plant: client 192.0.2.1: function 3 at unit 255, reads holding registers 0..3, "
          "denied: the unit is the gateway itself, with its status in input registers (function "
          "4)"));
}

TEST(StatusUnit, ShowsEachBusAndDeviceBehindTheOneBefore) {
  Settings settings = one_bus();
  settings.buses.push_back(settings.buses[0]);
  settings.buses[1].name = "line-b";
  settings.buses[1].line.device = "/dev/ttyS1";
  settings.devices = {{"axis", BusId{0}, 1, settings.buses[0].timing},
                      {"other", BusId{1}, 1, settings.buses[1].timing}};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, "0001 0000 0006 FF 04 0427 0002");  // the last register of bus 0; bus 1: open
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 07 FF 04 04 00 00 00 01"));
  rig.receive(1, "0002 0000 0006 FF 04 272F 0002");  // of device 0; device 1: its bus
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 07 FF 04 04 00 00 00 02"));
}

TEST(StatusUnit, ShowsDevicesThatDoNotAnswer) {
  Settings settings = one_bus();
  settings.devices = {{"axis", BusId{0}, 1, settings.buses[0].timing}};
  settings.devices[0].timing.offline_after = 1;
  settings.devices[0].timing.retries = 0;
  settings.devices[0].timing.quarantine = 500ms;
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, kRead);
  rig.advance(150ms);
  rig.take_sent(1);
  rig.receive(1, "0002 0000 0006 FF 04 2712 0002");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 07 FF 04 04 00 03 00 01"));
  rig.receive(1, "0003 0000 0006 FF 04 2722 0002");
  // 500 ms behind a timeout 100 ms after 8 characters of 573 us
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 03 00 00 00 07 FF 04 04 00 01 01 DB"));
  rig.receive(1, "0004 0000 0006 FF 04 041C 0002");  // bus 0: reads that lost their place
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 04 00 00 00 07 FF 04 04 00 00 00 00"));
}

TEST(StatusUnit, CountsAndClears) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1, kRead);
  rig.respond("01 83 02");
  rig.take_sent(1);
  rig.receive(1, "0002 0000 0006 FF 08 000D 0000");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 06 FF 08 00 0D 00 01"));
  rig.receive(1, "0003 0000 0006 FF 08 000A 0000 0004 0000 0006 FF 08 000D 0000");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 03 00 00 00 06 FF 08 00 0A 00 00",
                                            "00 04 00 00 00 06 FF 08 00 0D 00 00"));
  rig.receive(1, "0005 0000 0006 FF 06 0000 0001");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 05 00 00 00 03 FF 86 01"));
}

TEST(StatusUnit, HasNoDiagnosticRegisterAndCountsNoNakAndNoOverrun) {
  MachineRig rig;
  rig.connect(1);
  rig.receive(1,
              "0001 0000 0006 FF 08 0002 0000 0002 0000 0006 FF 08 0010 0000 "
              "0003 0000 0006 FF 08 0012 0000");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 01 00 00 00 06 FF 08 00 02 00 00",
                                            "00 02 00 00 00 06 FF 08 00 10 00 00",
                                            "00 03 00 00 00 06 FF 08 00 12 00 00"));
}

// As an operator asks for it: the same as by 08/10, and no device is in another state after it.
TEST(StatusUnit, IsClearedFromOutsideToo) {
  Settings settings = one_bus();
  settings.devices = {{"axis", BusId{0}, 1, settings.buses[0].timing}};
  MachineRig rig(settings);
  rig.connect(1);
  rig.receive(1, kRead);
  rig.advance(10ms);
  rig.respond("01 83 02");
  rig.receive(1, "0001 0000 0006 FF 08 000E 0000");  // counts what unit 255 was asked
  rig.clear_counters();
  rig.take_sent(1);
  rig.receive(1, "0002 0000 0006 FF 08 000D 0000 0003 0000 0006 FF 08 000E 0000");
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 02 00 00 00 06 FF 08 00 0D 00 00",
                                            "00 03 00 00 00 06 FF 08 00 0E 00 02"));
  rig.receive(1, "0004 0000 0006 FF 04 2710 0006");  // device 0: still answering, 0 transmissions
  EXPECT_THAT(rig.take_sent(1), ElementsAre("00 04 00 00 00 0F FF 04 0C 00 01 00 01 00 01 00 00 "
                                            "00 00 00 00"));
  EXPECT_THAT(rig.events, IsEmpty());
}

}  // namespace
}  // namespace mbgate::test::status_unit_test
