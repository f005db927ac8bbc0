// SPDX-License-Identifier: Apache-2.0
// Writes that go to their drive in several parts.
#include <gmock/gmock.h>

#include "support/machine_rig.hpp"

namespace mbgate::test::runs_test {
namespace {

constexpr auto* kLongWrite = "0001 0000 0015 01 10 0000 0007 0E 0001 0002 0003 0004 0005 0006 0007";

/// At most 5 registers a write; and a client gets the answer to its last request alone.
Settings splitting_drive() {
  Settings settings = one_bus();
  settings.listeners[0].one_at_a_time = true;
  drive::Device& device = settings.devices.emplace_back();
  device.name = "axis-x";
  device.timing = settings.buses[0].timing;
  device.profile.limits.write_registers = 5;
  device.split_writes = true;
  settings.routes[0].last_unit = 1;
  settings.routes[0].device = 0;
  return settings;
}

// It would be left half done.
TEST(Runs, AWriteInPartsIsFinishedThoughItsClientAsksAgainOrHalfCloses) {
  for (const bool asks : {true, false}) {
    MachineRig rig(splitting_drive());
    rig.connect(1);
    rig.receive(1, kLongWrite);
    if (asks) {
      rig.receive(1, "0002 0000 0006 FA 03 0000 0001");
    } else {
      rig.half_close(1);
    }
    rig.respond("01 10 00 00 00 05");
    rig.advance(30ms);
    rig.respond("01 10 00 05 00 02");
    EXPECT_THAT(rig.take_transmitted(), testing::SizeIs(2)) << asks;
    EXPECT_THAT(rig.take_sent(1),
                testing::ElementsAre(asks ? "00 02 00 00 00 03 FA 83 0A"
                                          : "00 01 00 00 00 06 01 10 00 00 00 07"));
  }
}

}  // namespace
}  // namespace mbgate::test::runs_test
