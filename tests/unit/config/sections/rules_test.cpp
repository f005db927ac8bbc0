// SPDX-License-Identifier: Apache-2.0
// What becomes of [[group]] and [[rule]]; what is wrong with them is in tests/config.
#include <gtest/gtest.h>

#include "config/load.hpp"

namespace mbgate::config {
namespace {

using modbus::Table;
using routing::RegisterSpan;

const std::string kConfigFolder = MBGATE_SOURCE_DIR "/tests/config/";

gateway::Settings settings_of_rules() {
  const auto loaded = load_settings(kConfigFolder + "valid/rules.toml",
                                    {.otherwise = {kConfigFolder + "profiles"}});
  EXPECT_TRUE(loaded.settings) << render(loaded.diagnostics);
  return loaded.settings.value_or(gateway::Settings());
}

TEST(Rules, HaveAllThatTheyName) {
  const auto settings = settings_of_rules();
  ASSERT_EQ(settings.rules.size(), 4U);
  const auto& rule = settings.rules[1];
  EXPECT_EQ(rule.name, "panels-move");
  EXPECT_EQ(rule.place, kConfigFolder + "valid/rules.toml:44");
  EXPECT_TRUE(rule.permits);
  ASSERT_EQ(rule.clients.size(), 1U);
  EXPECT_EQ(rule.clients[0].name, "panels");
  EXPECT_EQ(rule.clients[0].addresses,
            (routing::NetworkList{*routing::Network::parse("192.168.10.0/24"),
                                  *routing::Network::parse("fd00::7")}));
  EXPECT_EQ(rule.listeners, (std::vector{routing::ListenerId{0}}));
  EXPECT_EQ(rule.units, routing::UnitSet(0b11110));
  EXPECT_EQ(rule.devices, (std::vector<std::size_t>{0, 1}));
  EXPECT_EQ(rule.functions, routing::FunctionSet(1U << 6U | 1U << 15U | 1U << 16U));
  EXPECT_EQ(rule.access, routing::RuleAccess::write);
  EXPECT_EQ(rule.registers.spans, (std::vector<RegisterSpan>{{Table::holding_registers, 124, 124},
                                                             {Table::holding_registers, 124, 128},
                                                             {Table::coils, 0, 0xFFFF}}));
  EXPECT_TRUE(rule.registers.motion_commands && rule.registers.values && rule.registers.stops);
  EXPECT_FALSE(rule.registers.communication_registers);
  EXPECT_EQ(rule.per_second, 10U);
}

TEST(Rules, FitEverythingByDefault) {
  const auto settings = settings_of_rules();
  ASSERT_EQ(settings.rules.size(), 4U);
  EXPECT_FALSE(settings.rules[0].permits);
  EXPECT_TRUE(settings.rules[0].registers.communication_registers);
  EXPECT_EQ(settings.rules[2].clients.size(), 2U);
  EXPECT_EQ(settings.rules[2].access, routing::RuleAccess::read);
  auto last = settings.rules[3];
  EXPECT_TRUE(last.any_role);
  last.any_role = false;
  last.clients.clear();
  last.place.clear();
  EXPECT_EQ(last, routing::AccessRule());
}

TEST(Rules, AreCountedWithTheirEnd) {
  gateway::Settings settings;
  settings.rules.resize(1);
  settings.rules[0].place = "mbgate.toml:12";
  const std::string count = "configuration ok: 0 listeners, 0 buses, 0 devices, 0 routes\n";
  EXPECT_EQ(check_summary(settings),
            count + "1 rule: the last one, mbgate.toml:12, permits all other requests");
  settings.rules[0].permits = false;
  settings.rules[0].name = "rest";
  EXPECT_EQ(check_summary(settings),
            count + "1 rule: the last one, \"rest\" (mbgate.toml:12), denies all other requests");
  settings.rules.emplace_back().access = routing::RuleAccess::read;
  EXPECT_EQ(check_summary(settings),
            count + "2 rules: requests that match none of them are denied");
}

}  // namespace
}  // namespace mbgate::config
