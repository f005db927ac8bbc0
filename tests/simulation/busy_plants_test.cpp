// SPDX-License-Identifier: Apache-2.0
// The status says nothing of plants whose lines are busy, and carry what they are asked for.
#include "simulation/healthy_plants.hpp"

namespace mbgate::test {
namespace {

class BusyPlants : public HealthyPlants {};

TEST_P(BusyPlants, HaveNoDiagnosis) {
  run();
  EXPECT_EQ(exceptions_, 0U);
  EXPECT_GE(most_load_ + 10, GetParam().load) << "it was not busy";
}

class FullPlants : public HealthyPlants {};

// Somebody asks all the time, and nobody waits for long.
TEST_P(FullPlants, HaveNoDiagnosis) {
  run();
  EXPECT_EQ(exceptions_, 0U);
  EXPECT_GE(most_load_, 97U) << "it was not busy";
}

INSTANTIATE_TEST_SUITE_P(Simulated, FullPlants,
                         testing::Values(HealthyPlant{.name = "OneClientInAHurry",
                                                      .clients = 4,
                                                      .thinks = 2s,
                                                      .hurries = true,
                                                      .lasts = 5min},
                                         HealthyPlant{.name = "OneClientInAHurryAndDisturbances",
                                                      .baud = 9600,
                                                      .clients = 4,
                                                      .thinks = 2s,
                                                      .hurries = true,
                                                      .is_disturbed = true,
                                                      .lasts = 10min}),
                         [](const auto& tested) { return tested.param.name; });

INSTANTIATE_TEST_SUITE_P(
    Simulated, BusyPlants,
    testing::Values(
        HealthyPlant{.name = "SixteenClientsAt9600",
                     .baud = 9600,
                     .clients = 16,
                     .thinks = 800ms,
                     .load = 88,
                     .lasts = 10min},
        HealthyPlant{.name = "OneClient", .clients = 1, .thinks = 6ms, .load = 90, .lasts = 5min},
        HealthyPlant{.name = "ThirtyDrivesAt115200",
                     .baud = 115200,
                     .drives = 30,
                     .clients = 16,
                     .thinks = 200ms,
                     .load = 90,
                     .lasts = 4min},
        HealthyPlant{.name = "SlowDrivesWithinTheirTimeout",
                     .baud = 57600,
                     .drives = 8,
                     .clients = 4,
                     .load = 88,
                     .drives_take = 80ms,
                     .lasts = 10min},
        HealthyPlant{.name = "Ascii",
                     .framing = bus::Framing::ascii,
                     .drives = 3,
                     .clients = 4,
                     .load = 88,
                     .lasts = 5min}),
    [](const auto& tested) { return tested.param.name; });

}  // namespace
}  // namespace mbgate::test
