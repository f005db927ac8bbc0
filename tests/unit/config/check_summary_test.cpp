// SPDX-License-Identifier: Apache-2.0
#include "config/check_summary.hpp"

#include <gtest/gtest.h>

namespace mbgate::config {
namespace {

TEST(CheckSummary, CountsWhatIsConfigured) {
  gateway::Settings settings;
  settings.listeners.resize(2);
  settings.listeners[0].port = 1502;
  settings.listeners[1].port = 1503;
  settings.buses.resize(1);
  settings.devices.resize(3);
  EXPECT_EQ(check_summary(settings), "configuration ok: 2 listeners, 1 bus, 3 devices, 0 routes");
}

TEST(CheckSummary, HasALineForEachNeed) {
  gateway::Settings settings;
  settings.lock_memory = true;
  settings.buses.emplace_back().line.device = "/dev/ttyS0";
  EXPECT_EQ(check_summary(settings),
            "configuration ok: 0 listeners, 1 bus, 0 devices, 0 routes\n"
            "needs the group dialout: /dev/ttyS0\n"
            "needs lock_memory: the drop-in realtime.conf");
}

}  // namespace
}  // namespace mbgate::config
