// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "config/load.hpp"

namespace mbgate::config {
namespace {

TEST(CheckSummary, CountsWhatIsConfigured) {
  gateway::Settings settings;
  settings.listeners.resize(2);
  settings.listeners[0].port = 1502;
  settings.listeners[1].port = 1503;
  settings.devices.resize(3);
  EXPECT_EQ(check_summary(settings), "configuration ok: 2 listeners, 0 buses, 3 devices, 0 routes");
}

TEST(CheckSummary, HasALineForEachNeed) {
  gateway::Settings settings;
  settings.lock_memory = true;
  settings.buses.emplace_back().line.device = "/dev/ttyS0";
  EXPECT_EQ(check_summary(settings),
            "configuration ok: 0 listeners, 1 bus, 0 devices, 0 routes\n"
            "bus : writes have 2803ms by default; a stop is sent within 1174ms\n"
            "needs the group dialout: /dev/ttyS0\n"
            "needs lock_memory: the drop-in realtime.conf");
}

TEST(CheckSummary, SaysHowLongWritesAndStopsWait) {
  gateway::Settings settings;
  settings.buses.resize(2);
  settings.buses[0].name = "line-a";
  settings.buses[0].line.baud = modbus::Baud{115200};
  settings.buses[1].name = "cell";
  settings.buses[1].line.framing = bus::Framing::tcp;
  drive::Device& device = settings.devices.emplace_back();
  device.timing.response_timeout = std::chrono::milliseconds(300);
  // 264 characters of 11 bits take 25.21 ms; 20 ms for the adapter, 1.75 ms of silence.
  EXPECT_THAT(
      check_summary(settings),
      testing::HasSubstr("\nbus line-a: writes have 1151ms by default; a stop is sent within "
                         "347ms\nbus cell: writes have 2500ms by default; a stop is sent at "
                         "once"));
}

std::string stop_of(const bus::BusSettings& bus, const std::vector<drive::Device>& devices = {}) {
  gateway::Settings settings;
  settings.buses = {bus};
  settings.devices = devices;
  const std::string text = check_summary(settings);
  const auto from = text.find("a stop is sent ");
  return text.substr(from, text.find('\n', from) - from);
}

TEST(CheckSummary, CountsTheTurnaroundOfABroadcastAmongWhatAStopWaitsFor) {
  bus::BusSettings bus;
  bus.line.baud = modbus::Baud{115200};
  bus.timing.response_timeout = std::chrono::milliseconds(300);
  bus.turnaround = std::chrono::milliseconds(1500);
  // 256 characters of 11 bits take 24.44 ms, and 1.75 ms of silence.
  EXPECT_EQ(stop_of(bus), "a stop is sent within 1527ms");
}

TEST(CheckSummary, CountsSlowRegistersAmongWhatAStopWaitsFor) {
  bus::BusSettings bus;
  bus.line.baud = modbus::Baud{115200};
  drive::Device device;
  device.timing.response_timeout = std::chrono::milliseconds(300);
  device.profile.slow = {{{}, std::chrono::seconds(2)}};
  EXPECT_EQ(stop_of(bus, {device}), "a stop is sent within 2047ms");
}

TEST(CheckSummary, LetsAStopWaitForAServerThatReturnsNoIdentifiersOrIsNotReady) {
  bus::BusSettings bus;
  bus.line.framing = bus::Framing::tcp;
  bus.line.remote.emplace();
  bus.check_transaction = false;
  EXPECT_EQ(stop_of(bus), "a stop is sent within 1s");
  bus.connect_delay = std::chrono::milliseconds(500);
  EXPECT_EQ(stop_of(bus),
            "a stop is sent within 1s, on a new connection after connect_delay (500ms)");
  bus.check_transaction = true;
  EXPECT_EQ(stop_of(bus),
            "a stop is sent at once, on a new connection after connect_delay (500ms)");
}

}  // namespace
}  // namespace mbgate::config
