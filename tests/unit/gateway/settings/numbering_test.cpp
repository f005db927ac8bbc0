// SPDX-License-Identifier: Apache-2.0
// Which numbers new settings give to the listeners, buses and devices of the old ones.
#include <gmock/gmock.h>

#include "gateway/settings/settings_snapshot.hpp"
#include "unit/gateway/writes/stop_plant.hpp"

namespace mbgate::test {
namespace {

using gateway::numbered_after;
using testing::ElementsAre;

std::vector<std::string> names_of(const Settings& settings) {
  std::vector<std::string> names;
  for (const drive::Device& device : settings.devices) {
    names.push_back(device.is_gone() ? "-" : device.name);
  }
  return names;
}

Settings with(std::vector<drive::Device> devices) {
  Settings settings = stop_plant();
  settings.devices = std::move(devices);
  return settings;
}

TEST(Numbers, StayWithTheirNamesInAnyOrder) {
  const Settings next =
      numbered_after(stop_plant(), with({stoppable("axis-y", 2), stoppable("axis-x", 1)}));
  EXPECT_THAT(names_of(next), ElementsAre("axis-x", "axis-y"));
}

TEST(Numbers, AreNotUsedAgainForAnother) {
  const Settings without = numbered_after(stop_plant(), with({stoppable("axis-y", 2)}));
  EXPECT_THAT(names_of(without), ElementsAre("-", "axis-y"));
  const Settings other =
      numbered_after(without, with({stoppable("axis-z", 1), stoppable("axis-y", 2)}));
  EXPECT_THAT(names_of(other), ElementsAre("-", "axis-y", "axis-z"));
  const Settings back = numbered_after(other, stop_plant());
  EXPECT_THAT(names_of(back), ElementsAre("axis-x", "axis-y", "-"));
}

TEST(Numbers, AreThoseThatRoutesRulesAndGuardsMean) {
  Settings read = with({stoppable("axis-y", 2), stoppable("axis-z", 3)});
  read.routes.push_back({});
  read.routes.back().device = 1;
  read.rules.push_back({});
  read.rules.back().devices = {0, 1};
  read.guards.resize(2);
  read.guards[1].quiet = 7s;
  const Settings next = numbered_after(stop_plant(), read);
  EXPECT_THAT(names_of(next), ElementsAre("-", "axis-y", "axis-z"));
  EXPECT_EQ(next.routes.back().device, 2U);
  EXPECT_THAT(next.rules.back().devices, ElementsAre(1U, 2U));
  EXPECT_EQ(next.guards.at(2).quiet, 7s);
}

TEST(Numbers, OfBusesAreThoseThatDevicesAreOn) {
  Settings in_force = stop_plant();
  Settings read = stop_plant();
  read.buses.insert(read.buses.begin(), read.buses.front());
  read.buses.front().name = "line-b";
  read.listeners.front().bus = BusId{1};
  for (drive::Device& device : read.devices) {
    device.bus = BusId{1};
  }
  const Settings next = numbered_after(in_force, read);
  EXPECT_EQ(next.buses.at(1).name, "line-b");
  EXPECT_EQ(next.devices.front().bus, BusId{0});
  EXPECT_EQ(next.listeners.front().bus, BusId{0});
  EXPECT_TRUE(gateway::keeps_line(in_force, next, BusId{0}));
}

TEST(Numbers, OfABusWithoutIdentifiersAreThoseOfAnotherConnection) {
  Settings in_force = stop_plant();
  in_force.buses.front().line.framing = bus::Framing::tcp;
  Settings read = in_force;
  read.buses.front().check_transaction = false;
  EXPECT_FALSE(gateway::keeps_line(in_force, read, BusId{0}));
}

}  // namespace
}  // namespace mbgate::test
