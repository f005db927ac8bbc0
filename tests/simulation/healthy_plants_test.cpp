// SPDX-License-Identifier: Apache-2.0
// The status says nothing of plants in which nothing is wrong.
#include "simulation/healthy_plants.hpp"

namespace mbgate::test {
namespace {

TEST_P(HealthyPlants, HaveNoDiagnosis) {
  run();
  EXPECT_GT(answers_, 0U);
  EXPECT_EQ(exceptions_, 0U);
  EXPECT_GE(most_load_ + 10, GetParam().load) << "it was not busy";
}

INSTANTIATE_TEST_SUITE_P(
    Simulated, HealthyPlants,
    testing::Values(
        HealthyPlant{.name = "TwoDrivesAt9600", .baud = 9600, .drives = 2, .clients = 1},
        HealthyPlant{.name = "ThirtyDrives", .baud = 38400, .drives = 30, .thinks = 300ms},
        HealthyPlant{.name = "HardlyAnyRequests", .drives = 2, .clients = 1, .thinks = 30s},
        HealthyPlant{.name = "SlowDrivesWithinTheirTimeout", .thinks = 300ms, .drives_take = 80ms},
        HealthyPlant{.name = "Ascii", .framing = bus::Framing::ascii, .drives = 3, .lasts = 15min},
        HealthyPlant{
            .name = "ModbusTcp", .framing = bus::Framing::tcp, .clients = 4, .lasts = 10min},
        HealthyPlant{.name = "KnownEcho", .baud = 57600, .echo = true, .lasts = 10min}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace mbgate::test
