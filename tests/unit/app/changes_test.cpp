// SPDX-License-Identifier: Apache-2.0
#include "app/changes.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "gateway/settings/settings_snapshot.hpp"

namespace mbgate::app {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::IsEmpty;

gateway::Settings plant() {
  gateway::Settings settings;
  settings.listeners.emplace_back().name = "plant";
  settings.buses.emplace_back().name = "line-a";
  settings.buses[0].line.device = "/dev/ttyS0";
  auto& device = settings.devices.emplace_back();
  device.name = "axis-x";
  device.timing = settings.buses[0].timing;
  auto& route = settings.routes.emplace_back();
  route.first_unit = route.last_unit = 1;
  route.buses = {gateway::BusId{0}};
  route.device = 0;
  return settings;
}

std::vector<std::string> changes(const gateway::Settings& old, const gateway::Settings& read) {
  return changes_between(old, gateway::numbered_after(old, read));
}

TEST(Changes, AreNoneWhereNothingIsChanged) { EXPECT_THAT(changes(plant(), plant()), IsEmpty()); }

TEST(Changes, AreToldOfCertificatesWithTheirListeners) {
  auto with_tls = plant();
  with_tls.tls.push_back({.name = "gate", .certificate = "/a.crt"});
  with_tls.listeners[0].tls = 0;
  EXPECT_THAT(changes(plant(), with_tls), ElementsAre("listener plant: tls"));
  auto other = with_tls;
  other.tls[0].certificate = "/b.crt";
  EXPECT_THAT(changes(with_tls, other), ElementsAre("listener plant: tls"));
  EXPECT_THAT(changes(other, other), IsEmpty());
}

TEST(Changes, AreToldWithTheValuesOfPlainKeys) {
  auto next = plant();
  next.wake_early = 0us;
  next.listeners[0].tcp.keepalive_idle = 1min;
  next.buses[0].line.baud = modbus::Baud{115200};
  next.buses[0].line.format.parity = modbus::Parity::none;
  next.buses[0].frame_gap = 3ms;
  next.devices[0].word_order = drive::WordOrder::little;
  next.devices[0].cache = 50ms;
  next.devices[0].limits_values = true;
  next.devices[0].profile.name = "moons-m3";
  EXPECT_THAT(
      changes(plant(), next),
      ElementsAre("gateway: wake_early \"40us\" -> \"0s\"",
                  "listener plant: keepalive_idle \"30s\" -> \"1m\"",
                  "bus line-a: baud 19200 -> 115200, frame_gap - -> \"3ms\", "
                  "parity \"even\" -> \"none\"",
                  "device axis-x: profile \"generic\" -> \"moons-m3\", word_order - -> \"little\", "
                  "write_echo \"value\" -> \"address\", cache \"0s\" -> \"50ms\""));
}

// Which drive an address meant before must be found afterwards.
TEST(Changes, AreToldWithNamesAndNumbers) {
  auto next = plant();
  next.status_unit = 200;
  next.listeners[0].port = 1503;
  next.listeners[0].bus = gateway::BusId{1};
  next.buses.emplace_back().name = "line-b";
  next.buses[0].line.framing = bus::Framing::ascii;
  next.buses[0].line.remote = bus::Endpoint{"far", 4001};
  next.buses[0].line.echo = true;
  next.devices[0].bus = gateway::BusId{1};
  next.devices[0].timing = next.buses[1].timing;
  next.devices[0].address = 6;
  EXPECT_THAT(changes(plant(), next),
              ElementsAre(testing::StartsWith("gateway: unit "),
                          "listener plant: port 502 -> 1503, bus - -> \"line-b\"",
                          "bus line-a: mode \"rtu\" -> \"ascii\", host or port - -> far:4001, "
                          "echo - -> true",
                          "bus line-b added",
                          "device axis-x: bus \"line-a\" -> \"line-b\", address 1 -> 6"));
}

TEST(Changes, OfHttpAreTold) {
  auto next = plant();
  next.http.listen = {*routing::ListenAddress::parse("127.0.0.1:8080")};
  next.http.hosts = {"gateway.plant"};
  next.http.max_streams = 2;
  EXPECT_THAT(changes(plant(), next), ElementsAre("http: listen, hosts, max_streams 64 -> 2"));
  next.http = {.allow = {*routing::Network::parse("10.0.0.7")}};
  EXPECT_THAT(changes(plant(), next), ElementsAre("http: allow"));
}

TEST(Changes, OfABusAreNotToldAgainOfDevicesThatHaveItsTimes) {
  auto next = plant();
  next.buses[0].timing.retries = 2;
  next.devices[0].timing.retries = 2;
  EXPECT_THAT(changes(plant(), next), ElementsAre("bus line-a: retries 1 -> 2"));
  next.devices[0].timing.retries = 5;
  EXPECT_THAT(changes(plant(), next),
              ElementsAre("bus line-a: retries 1 -> 2", "device axis-x: retries 1 -> 5"));
}

TEST(Changes, NameWhatComesAndGoes) {
  auto next = plant();
  next.buses.emplace_back().name = "line-b";
  next.listeners[0].name = "office";
  next.devices.clear();
  next.routes[0].device.reset();
  next.routes.push_back(next.routes[0]);
  next.routes[1].first_unit = next.routes[1].last_unit = 2;
  next.weights.push_back({*routing::Network::parse("10.0.0.1"), 4});
  EXPECT_THAT(changes(plant(), next),
              ElementsAre("listener plant removed", "listener office added", "bus line-b added",
                          "device axis-x removed",
                          "route of unit 1: device axis-x -> bus line-a from address 0",
                          "route of unit 2 added: bus line-a from address 0", "clients: weights"));
}

TEST(Changes, OfGuardsStandAtTheirDevice) {
  auto next = plant();
  next.guards.resize(1);
  next.guards[0].writer = gateway::WriterRule::first;
  next.guards[0].quiet = 10s;
  EXPECT_THAT(changes(plant(), next),
              ElementsAre("device axis-x: writer, quiet \"0s\" -> \"10s\""));
}

TEST(Changes, OfRulesAreNotTheirLines) {
  auto old = plant();
  old.rules.emplace_back().place = "mbgate.toml:12";
  auto next = old;
  next.rules[0].place = "mbgate.toml:13";
  EXPECT_THAT(changes(old, next), testing::IsEmpty());
  next.rules[0].permits = false;
  EXPECT_THAT(changes(old, next), ElementsAre("access rules: mbgate.toml:12 -> mbgate.toml:13"));
  EXPECT_THAT(changes(old, plant()), ElementsAre("access rules: mbgate.toml:12 -> none"));
  next = old;
  next.rules.emplace_back().permits = false;
  old = next;
  std::swap(next.rules[0], next.rules[1]);
  EXPECT_THAT(changes(old, next), ElementsAre("access rules: their order or number has changed"));
}

}  // namespace
}  // namespace mbgate::app
