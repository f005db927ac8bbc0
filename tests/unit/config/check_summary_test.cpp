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

}  // namespace
}  // namespace mbgate::config
