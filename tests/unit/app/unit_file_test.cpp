// SPDX-License-Identifier: Apache-2.0
// What systemd/mbgated.service lets the daemon do.
#include <gtest/gtest.h>

#include <fstream>
#include <set>
#include <string>

namespace mbgate::app {
namespace {

std::set<std::string> lines_of_unit() {
  std::ifstream file(std::string(MBGATE_SOURCE_DIR) + "/systemd/mbgated.service");
  std::set<std::string> lines;
  for (std::string line; std::getline(file, line);) {
    lines.insert(line);
  }
  return lines;
}

/// The names are those of /proc/devices.
TEST(UnitFile, AllowsTheDriversOfSerialPorts) {
  const auto lines = lines_of_unit();
  EXPECT_TRUE(lines.contains("DevicePolicy=closed"));
  for (const auto* driver : {"ttyS", "ttyUSB", "ttyACM", "ttyAMA", "ttymxc", "ttySC", "ttyO",
                             "ttyLP", "ttySTM", "ttyTHS", "ttyXRUSB", "ttyMX", "rfcomm"}) {
    EXPECT_TRUE(lines.contains("DeviceAllow=char-" + std::string(driver) + " rw")) << driver;
  }
}

}  // namespace
}  // namespace mbgate::app
