// SPDX-License-Identifier: Apache-2.0
#include "config/check_summary.hpp"

#include <gtest/gtest.h>

namespace mbgate::config {
namespace {

TEST(CheckSummary, CountsWhatIsConfigured) {
  gateway::Settings settings;
  settings.listeners.resize(2);
  settings.buses.resize(1);
  settings.devices.resize(3);
  EXPECT_EQ(check_summary(settings), "configuration ok: 2 listeners, 1 bus, 3 devices, 0 routes");
}

}  // namespace
}  // namespace mbgate::config
