// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <array>
#include <boost/json.hpp>

#include "app/control/control_answers.hpp"

namespace mbgate::app {
namespace {

/// One device on one line.
gateway::StatusReport one_device() {
  gateway::StatusReport report;
  report.buses.emplace_back().name = "line-a";
  report.devices.emplace_back().name = "axis";
  return report;
}

boost::json::object device_of(const gateway::StatusReport& report) {
  return status_json(report, {}).at("devices").as_array().at(0).as_object();
}

TEST(StatusJson, HasTheExceptionsThatThereWere) {
  auto report = one_device();
  EXPECT_EQ(boost::json::serialize(device_of(report).at("exceptions")), "{}");
  auto& exceptions = report.devices[0].counters.exceptions_by_code;
  for (const auto code : std::to_array<std::uint8_t>({0x02, 0x0A, 0x02, 0x11, 0x00, 0x01})) {
    exceptions.note(code);
  }
  EXPECT_EQ(boost::json::serialize(device_of(report).at("exceptions")),
            R"({"01":1,"02":2,"0A":1,"other":2})");
}

TEST(StatusJson, SaysSinceWhenADeviceIsInItsState) {
  auto report = one_device();
  EXPECT_TRUE(device_of(report).at("state_since_s").is_null());
  report.devices[0].state_since = std::chrono::milliseconds(4500);
  EXPECT_EQ(device_of(report).at("state_since_s"), 4.5);
}

TEST(StatusJson, SaysHowLongACharacterTakesAndWhichSilenceIsKept) {
  auto report = one_device();
  report.buses[0].character = std::chrono::microseconds(1146);
  report.buses[0].frame_gap = std::chrono::microseconds(4011);
  const auto bus_of = [&] { return status_json(report, {}).at("buses").as_array().at(0); };
  EXPECT_EQ(bus_of().at("character_ms"), 1.146);
  EXPECT_EQ(bus_of().at("frame_gap_ms"), 4.011);
  report.buses[0].framing = bus::Framing::tcp;
  EXPECT_TRUE(bus_of().at("character_ms").is_null());
  EXPECT_TRUE(bus_of().at("frame_gap_ms").is_null());
}

}  // namespace
}  // namespace mbgate::app
