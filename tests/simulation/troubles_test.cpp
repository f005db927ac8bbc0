// SPDX-License-Identifier: Apache-2.0
// What a pty cannot show: a port whose parity is not that of the drives.
#include "gateway/status/diagnosis.hpp"
#include "simulation/polling.hpp"

namespace mbgate::test {
namespace {

class PortInAnotherMode : public testing::TestWithParam<sim::PortMode> {};

// Drives are silent in all of these, and also where A and B are exchanged: all are named.
TEST_P(PortInAnotherMode, HasAllThatLooksAlikeNamed) {
  BusPlan plan = bus_plan({1, 2}, modbus::Baud{19200});
  plan.bus.line.format = {8, modbus::Parity::even, 1};
  const OneBus bus = one_bus(plan);
  Polling polling(bus.settings, bus.devices);
  polling.world().wire(0).set_port(GetParam());
  for (const std::uint8_t unit : {std::uint8_t{1}, std::uint8_t{2}}) {
    polling.add({.host = unit, .next = [unit] { return Registers{unit, kFirst, 4}; }});
  }
  polling.run_for(10s);
  const auto all =
      gateway::diagnose(polling.world().gateway().report_status(10s, polling.world().now()));
  ASSERT_EQ(all.size(), 1U);
  EXPECT_EQ(all[0].subject, "bus line");
  EXPECT_EQ(all[0].finding, "nothing answers");
  EXPECT_EQ(all[0].look_at,
            "power; the cable and its plug; A and B; whether `device` is the port of this line; "
            "unit addresses; the drives' setting, here 19200 baud 8E1; RTU or ASCII (`mode`); what "
            "switches "
            "the direction (`rs485`)");
}

INSTANTIATE_TEST_SUITE_P(
    RateAndParity, PortInAnotherMode,
    testing::Values(sim::PortMode{modbus::Baud{19200}, {8, modbus::Parity::none, 1}},
                    sim::PortMode{modbus::Baud{19200}, {8, modbus::Parity::odd, 1}},
                    sim::PortMode{modbus::Baud{9600}, {8, modbus::Parity::even, 1}}));

}  // namespace
}  // namespace mbgate::test
