// SPDX-License-Identifier: Apache-2.0
// What a device says of late answers, stops, its writers and its failsafe, and what clients weigh.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "config/load.hpp"

namespace mbgate::config::guards_test {
namespace {

using namespace std::chrono_literals;
using drive::WriteMatch;
using gateway::WriterRule;
using modbus::Table;
using testing::Contains;
using testing::ElementsAre;

const std::filesystem::path kFolder = std::filesystem::path(MBGATE_SOURCE_DIR) / "tests/config";

gateway::Settings settings_of(const std::string& file) {
  const auto loaded =
      load_settings(kFolder / "valid" / file, {.otherwise = {kFolder / "profiles"}});
  EXPECT_EQ(render(loaded.diagnostics), "");
  return loaded.settings.value_or(gateway::Settings());
}

routing::ClientAddress address(std::string_view text) {
  return *routing::ClientAddress::parse(text);
}

std::vector<std::vector<std::uint8_t>> failsafe_of(const gateway::Settings& settings,
                                                   std::size_t device) {
  std::vector<std::vector<std::uint8_t>> pdus;
  for (const auto& request : settings.guards.at(device).failsafe) {
    const auto bytes = request.pdu().bytes();
    pdus.emplace_back(bytes.begin(), bytes.end());
  }
  return pdus;
}

using Pdu = std::vector<std::uint8_t>;

TEST(DeviceHealth, IsStatedByTheDevice) {
  const auto settings = settings_of("every-key.toml");
  const auto& own = settings.devices.at(0).timing;
  EXPECT_EQ(own.stop_retries, 0U);
  EXPECT_EQ(own.quarantine, 200ms);
  EXPECT_EQ(own.quarantine_max, 200ms);
  EXPECT_EQ(own.offline_after, 0U);
  EXPECT_EQ(own.probe_interval, 500ms);
  EXPECT_EQ(own.probe_timeout, 20ms);
}

TEST(DeviceHealth, IsInheritedFromTheBus) {
  const auto settings = settings_of("every-key.toml");
  for (const auto& timing : {settings.buses.at(0).timing, settings.devices.at(1).timing}) {
    EXPECT_EQ(timing.stop_retries, 5U);
    EXPECT_EQ(timing.quarantine, 400ms);
    EXPECT_EQ(timing.quarantine_max, 3s);
    EXPECT_EQ(timing.offline_after, 4U);
    EXPECT_EQ(timing.probe_interval, 1s);
    EXPECT_EQ(timing.probe_timeout, 30ms);
  }
}

TEST(DeviceHealth, IsStatedForServersToo) {
  const auto settings = settings_of("guards.toml");
  EXPECT_EQ(settings.buses.at(1).timing.offline_after, 1U);
  EXPECT_EQ(settings.buses.at(1).stop_wait, 20ms);
  EXPECT_EQ(settings.devices.at(4).timing.offline_after, 2U);
}

/// A response timeout of 20 s would begin with more than the 10 s of the default.
TEST(LongestQuarantine, MakesRoomForTheFirstUnlessStated) {
  const auto settings = settings_of("guards.toml");
  EXPECT_EQ(settings.buses.at(0).timing.quarantine_max, 20s);
  EXPECT_EQ(settings.devices.at(0).timing.quarantine_max, 20s);
  EXPECT_EQ(settings.devices.at(1).timing.quarantine_max, 10s);
}

TEST(OwnStops, AreAddedToThoseOfTheProfile) {
  const auto generic = settings_of("every-key.toml").devices.at(0);
  EXPECT_THAT(generic.profile.stops,
              ElementsAre(WriteMatch{Table::holding_registers, 200, 1, 0, false, 2},
                          WriteMatch{Table::coils, 7, 0xFFFF, 0xFF00, false, 0}));
  const auto settable = settings_of("guards.toml").devices.at(0);
  EXPECT_EQ(settable.profile.stops.size(), 3U);
  EXPECT_THAT(settable.profile.stops,
              Contains(WriteMatch{Table::holding_registers, 62, 0xFFFF, 0xE3, false, 3}));
}

TEST(Writer, IsAnyoneTheFirstOrListed) {
  const auto settings = settings_of("every-key.toml");
  ASSERT_EQ(settings.guards.size(), settings.devices.size());
  EXPECT_EQ(settings.guards[0].writer, WriterRule::first);
  EXPECT_EQ(settings.guards[0].writer_hold, 2s);
  EXPECT_EQ(settings.guards[1].writer, WriterRule::listed);
  EXPECT_TRUE(contains(settings.guards[1].writers.networks, address("192.168.10.5")));
  EXPECT_TRUE(contains(settings.guards[1].writers.networks, address("10.9.8.7")));
  EXPECT_FALSE(contains(settings.guards[1].writers.networks, address("192.168.10.6")));
  const auto others = settings_of("guards.toml");
  ASSERT_EQ(others.guards.size(), others.devices.size());
  EXPECT_EQ(others.guards[0].writer, WriterRule::any);
  EXPECT_EQ(others.guards[0].writer_hold, 5s);
}

TEST(Failsafe, IsWrittenOneByOne) {
  const auto settings = settings_of("every-key.toml");
  EXPECT_THAT(failsafe_of(settings, 0),
              ElementsAre(Pdu{0x06, 0x00, 0x7C, 0x00, 0xE2}, Pdu{0x05, 0x00, 0x05, 0xFF, 0x00}));
  EXPECT_EQ(settings.guards.at(0).quiet, 3s);
  EXPECT_TRUE(settings.guards.at(1).failsafe.empty());
  EXPECT_EQ(settings.guards.at(1).quiet, 0s);
  EXPECT_EQ(settings.guards.at(0).failsafe_grace, 2s);
  EXPECT_EQ(settings.guards.at(1).failsafe_grace, 1s);
  EXPECT_TRUE(settings.guards.at(0).failsafe_on_exit);
  EXPECT_FALSE(settings.guards.at(1).failsafe_on_exit);
}

TEST(Failsafe, HasTheFunctionThatTheDeviceTakes) {
  const auto settings = settings_of("guards.toml");
  EXPECT_THAT(failsafe_of(settings, 0),
              ElementsAre(Pdu{0x10, 0x00, 0x46, 0x00, 0x01, 0x02, 0x00, 0xE1}));
  EXPECT_THAT(failsafe_of(settings, 1),
              ElementsAre(Pdu{0x05, 0x00, 0x0C, 0xFF, 0x00}, Pdu{0x05, 0x00, 0x0D, 0x00, 0x00}));
  EXPECT_THAT(failsafe_of(settings, 2), ElementsAre(Pdu{0x0F, 0x00, 0x0C, 0x00, 0x01, 0x01, 0x01}));
  EXPECT_THAT(failsafe_of(settings, 3), ElementsAre(Pdu{0x06, 0x00, 0x50, 0x00, 0x05}));
}

TEST(Cache, IsOffUnlessStated) {
  const auto settings = settings_of("every-key.toml");
  EXPECT_EQ(settings.devices.at(0).cache, 50ms);
  EXPECT_EQ(settings.devices.at(1).cache, 0s);
}

TEST(ClientWeights, KeepTheirOrder) {
  const auto settings = settings_of("every-key.toml");
  ASSERT_EQ(settings.weights.size(), 2U);
  EXPECT_TRUE(settings.weights[0].network.contains(address("192.168.10.5")));
  EXPECT_FALSE(settings.weights[0].network.contains(address("192.168.10.6")));
  EXPECT_EQ(settings.weights[0].weight, 4U);
  EXPECT_TRUE(settings.weights[1].network.contains(address("192.168.10.6")));
  EXPECT_EQ(settings.weights[1].weight, 2U);
}

}  // namespace
}  // namespace mbgate::config::guards_test
