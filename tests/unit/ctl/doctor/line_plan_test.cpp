// SPDX-License-Identifier: Apache-2.0
#include "ctl/doctor/line_plan.hpp"

#include <gtest/gtest.h>

#include "support/config_text.hpp"

namespace mbgate::ctl {
namespace {

using std::chrono::milliseconds;

constexpr const char* kBuses = R"(
[[bus]]
name = "line-a"
device = "/dev/ttyUSB0"
baud = 115200
parity = "none"
echo = true
low_latency = false
frame_gap = "3ms"
response_timeout = "400ms"
[[bus]]
name = "line-b"
device = "/dev/ttyUSB1"
[[bus]]
name = "far"
device = "tcp://192.168.1.7:4001"
[[bus]]
name = "text"
device = "/dev/ttyUSB2"
mode = "ascii"
[[device]]
name = "axis-x"
bus = "line-a"
address = 3
response_timeout = "200ms"
response_wait = "50ms"
gap = "2ms"
[[device]]
name = "turntable"
bus = "line-b"
address = 17
[[listen]]
name = "plant"
port = 1502
bus = "line-a"
)";

Result<LinePlan, std::string> plan_for(const DoctorCommand& command, const std::string& text) {
  const auto loaded = test::load_settings_text("test.toml", text);
  if (!loaded.settings) {
    return {boost::system::in_place_error, config::render(loaded.diagnostics)};
  }
  return plan_of_bus(command, *loaded.settings);
}

std::string plan_error(const std::string& bus, const std::string& text) {
  DoctorCommand command;
  command.bus = bus;
  const auto plan = plan_for(command, text);
  return plan ? "no error" : plan.error();
}

TEST(LinePlan, TakesLineAndDevicesOfABus) {
  DoctorCommand command;
  command.bus = "line-a";
  const auto plan = plan_for(command, kBuses);
  ASSERT_TRUE(plan) << plan.error();
  EXPECT_EQ(plan->device, "/dev/ttyUSB0");
  EXPECT_EQ(mode_text(plan->mode), "115200 8N1");
  EXPECT_EQ(plan->echo, true);
  EXPECT_EQ(plan->low_latency, false);
  EXPECT_EQ(plan->nobody, std::nullopt);
  ASSERT_EQ(plan->units.size(), 1U);
  EXPECT_EQ(unit_text(plan->units[0]), "unit 3 (axis-x)");
  EXPECT_EQ(plan->units[0].timeout, milliseconds(250));
  EXPECT_EQ(plan->units[0].response_wait, milliseconds(50));
  EXPECT_EQ(plan->units[0].pause, milliseconds(5));
}

TEST(LinePlan, AsksTheUnitsThatAreNamedInstead) {
  DoctorCommand command;
  command.bus = "line-a";
  command.units = {3, 9};
  const auto plan = plan_for(command, kBuses);
  ASSERT_TRUE(plan) << plan.error();
  ASSERT_EQ(plan->units.size(), 2U);
  EXPECT_EQ(plan->units[0].name, "axis-x");
  EXPECT_EQ(unit_text(plan->units[1]), "unit 9");
  EXPECT_EQ(plan->units[1].timeout, milliseconds(400));
}

TEST(LinePlan, NeedsNoNameWhereThereIsOneSerialLine) {
  const auto plan = plan_for({}, R"(
[[bus]]
name = "line-b"
device = "/dev/ttyUSB1"
rs485 = "kernel"
[[listen]]
name = "plant"
port = 1502
bus = "line-b"
)");
  ASSERT_TRUE(plan) << plan.error();
  EXPECT_EQ(plan->device, "/dev/ttyUSB1");
  EXPECT_EQ(plan->nobody, "only mbgated changes the direction of this line (its key rs485)");
}

TEST(LinePlan, SaysWhatBusesThereAre) {
  EXPECT_EQ(plan_error("", kBuses), "which bus? --bus with one of line-a, line-b, text");
  EXPECT_EQ(plan_error("x", kBuses),
            "the configuration has no bus x; it has line-a, line-b, far, text");
  EXPECT_EQ(plan_error("far", kBuses),
            "bus far is a TCP connection to 192.168.1.7, not a serial port");
  EXPECT_EQ(plan_error("text", kBuses),
            "bus text has ASCII frames: only lines with RTU frames can be examined");
}

TEST(LinePlan, HasNobodyToAskAtAPortOfWhichNothingIsKnown) {
  DoctorCommand command;
  command.port = ExaminedPort{"/dev/ttyUSB0", {}, milliseconds(700)};
  EXPECT_EQ(plan_of_port(command).nobody,
            "no unit is known: name one with --address, or find one with mbgatectl scan --device "
            "/dev/ttyUSB0");
  command.units = {5};
  const auto plan = plan_of_port(command);
  EXPECT_EQ(plan.nobody, std::nullopt);
  ASSERT_EQ(plan.units.size(), 1U);
  EXPECT_EQ(plan.units[0].address, 5);
  EXPECT_EQ(plan.units[0].timeout, milliseconds(700));
}

}  // namespace
}  // namespace mbgate::ctl
