// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include "app/changes.hpp"

namespace mbgate::app {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

gateway::Settings routed() {
  gateway::Settings settings;
  settings.listeners.emplace_back().name = "plant";
  settings.buses.emplace_back().name = "line-a";
  settings.buses.emplace_back().name = "line-b";
  settings.devices.emplace_back().name = "axis-x";
  settings.devices.emplace_back().name = "axis-y";
  auto& route = settings.routes.emplace_back();
  route.first_unit = route.last_unit = 11;
  route.buses = {gateway::BusId{0}};
  route.device = 0;
  return settings;
}

TEST(RouteChanges, AreNoneWhereOnlyTheOrderDiffers) {
  auto old = routed();
  old.routes.push_back(old.routes[0]);
  old.routes[1].first_unit = old.routes[1].last_unit = 12;
  auto next = old;
  std::swap(next.routes[0], next.routes[1]);
  EXPECT_THAT(route_changes(old, next), IsEmpty());
}

TEST(RouteChanges, SayWhatItWasAndWhatItIs) {
  auto next = routed();
  auto& route = next.routes[0];
  route.device = 1;
  route.access = routing::Access::read_only;
  route.functions = {};
  route.functions.allowed.set(3).set(6);
  route.windows = {{modbus::Table::holding_registers, 0, 4, modbus::Table::holding_registers, 100}};
  route.word_order = drive::WordOrder::little;
  route.deadline = 200ms;
  EXPECT_THAT(
      route_changes(routed(), next),
      ElementsAre(
          "route of unit 11: device axis-x -> device axis-y, access read-write -> read-only, "
          "functions all -> 3 6, registers all -> holding 0..3=holding 100, word_order - -> "
          "little, deadline - -> 200ms"));
}

TEST(RouteChanges, NameDiagnosticsThatPassByThemselves) {
  auto next = routed();
  auto& functions = next.routes[0].functions = {};
  functions.change_delimiter = functions.force_listen_only = true;
  EXPECT_THAT(route_changes(routed(), next),
              ElementsAre("route of unit 11: functions all -> 8/3 8/4"));
  functions.allowed.set(3).set(8);  // 8 has 8/3 too where no line is ASCII
  EXPECT_THAT(route_changes(routed(), next),
              ElementsAre("route of unit 11: functions all -> 3 8 8/4"));
}

TEST(RouteChanges, NameWhatComesAndGoes) {
  auto next = routed();
  auto& route = next.routes[0];
  route.listener = gateway::ListenerId{0};
  route.device.reset();
  route.first_unit = route.first_address = 1;
  route.last_unit = 247;
  auto& broadcast = next.routes.emplace_back();
  broadcast.buses = {gateway::BusId{0}, gateway::BusId{1}};
  EXPECT_THAT(route_changes(routed(), next),
              ElementsAre("route of units 1..247 (listener plant) added: bus line-a from address 1",
                          "route of unit 0 added: bus line-a, line-b",
                          "route of unit 11 removed: device "
                          "axis-x"));
}

}  // namespace
}  // namespace mbgate::app
