// SPDX-License-Identifier: Apache-2.0
// The files in conf/ and in examples/ are what users start from.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "support/config_text.hpp"

namespace mbgate::config::shipped_files_test {
namespace {

using namespace std::chrono_literals;

const std::string kFolder = std::string(MBGATE_SOURCE_DIR) + "/conf/";

std::string text_of(const std::string& path) {
  std::stringstream text;
  text << std::ifstream(path).rdbuf();
  return text.str();
}

TEST(CompleteFile, LoadsWithoutAWord) {
  const auto loaded = load_settings(kFolder + "mbgate.toml");
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->listeners.size(), 2U);
}

/// "# key = ..." and "# [[table]]", unlike the sentences around them.
bool is_commented_setting(const std::string& line) {
  if (!line.starts_with("# ")) {
    return false;
  }
  const auto key_end = line.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_", 2);
  return line.starts_with("# [[") ||
         (key_end != std::string::npos && key_end > 2 && line.substr(key_end).starts_with(" = "));
}

/// What the package puts into /etc/mbgate.
TEST(InstalledFile, ConfiguresNothingAndHasAnExampleThatLoads) {
  const auto shipped = load_settings(kFolder + "etc/mbgate.toml");
  ASSERT_TRUE(shipped.settings);
  EXPECT_TRUE(shipped.settings->buses.empty());
  std::istringstream lines(text_of(kFolder + "etc/mbgate.toml"));
  std::string text;
  for (std::string line; std::getline(lines, line);) {
    text += is_commented_setting(line) ? line.substr(2) + "\n" : line + "\n";
  }
  const auto loaded = test::load_settings_text("mbgate.toml", text);
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->listeners.size(), 1U);
  EXPECT_EQ(loaded.settings->devices.size(), 1U);
}

/// What a newcomer copies first.
TEST(Readme, HasACompleteConfiguration) {
  const auto text = text_of(MBGATE_SOURCE_DIR "/README.md");
  const std::string fence = "```toml\n";
  const auto start = text.find(fence);
  ASSERT_NE(start, std::string::npos);
  const auto rest = text.substr(start + fence.size());
  const auto loaded = test::load_settings_text("README.md", rest.substr(0, rest.find("```")));
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->listeners.size(), 1U);
}

/// The example of the page on access rules, behind the complete configuration.
TEST(AccessRulesPage, HasRulesThatLoad) {
  const auto page = text_of(MBGATE_SOURCE_DIR "/docs/access-rules.md");
  const std::string fence = "```toml\n";
  const auto start = page.find(fence);
  ASSERT_NE(start, std::string::npos);
  const auto rest = page.substr(start + fence.size());
  const auto loaded = test::load_settings_text(
      kFolder + "mbgate.toml", text_of(kFolder + "mbgate.toml") + rest.substr(0, rest.find("```")));
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->rules.size(), 5U);
}

/// The keys that are commented out are true as well: nothing there may rot.
TEST(CompleteFile, LoadsWithEveryCommentedKeyToo) {
  std::istringstream lines(text_of(kFolder + "mbgate.toml"));
  std::string text;
  int commented = 0;
  for (std::string line; std::getline(lines, line);) {
    commented += is_commented_setting(line) ? 1 : 0;
    // Some keys are for a line that the kernel turns round.
    const bool direction = line.starts_with("rs485 = \"off\"");
    text += direction                    ? "rs485 = \"kernel\"\n"
            : is_commented_setting(line) ? line.substr(2) + "\n"
                                         : line + "\n";
  }
  EXPECT_EQ(commented, 96);
  const auto loaded = test::load_settings_text(kFolder + "mbgate.toml", text);
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  EXPECT_EQ(loaded.settings->routes.size(), 7U);
  EXPECT_EQ(loaded.settings->devices.back().address, 255);
  EXPECT_EQ(loaded.settings->buses.back().line.framing, bus::Framing::tcp);
  EXPECT_EQ(loaded.settings->buses[0].frame_gap, 3ms);
  EXPECT_EQ(loaded.settings->listeners[0].allow.size(), 1U);
  EXPECT_EQ(loaded.settings->listeners[0].tls, 0U);
  EXPECT_EQ(loaded.settings->tls.at(0).authorities, kFolder + "certs/ca.crt");
  EXPECT_EQ(loaded.settings->http.listen.size(), 1U);
  EXPECT_EQ(loaded.settings->guards.at(0).failsafe.size(), 1U);
  EXPECT_EQ(loaded.settings->guards[0].writer, gateway::WriterRule::first);
  EXPECT_EQ(loaded.settings->weights.size(), 1U);
  EXPECT_EQ(loaded.settings->rules.size(), 2U);
  // What stands there is the default all the same.
  const bus::BusSettings bus;
  const gateway::DeviceGuard guard;
  const auto& times = loaded.settings->buses[0].timing;
  EXPECT_EQ(times.quarantine, bus.timing.quarantine_or_default());
  EXPECT_EQ(times.probe_timeout, bus.timing.probe_timeout_or_default());
  const bus::BusSettings& cell = loaded.settings->buses.back();
  EXPECT_EQ(cell.check_unit, bus.check_unit);
  EXPECT_EQ(cell.check_transaction, bus.check_transaction);
  EXPECT_EQ(cell.replace_after, bus.replace_after);
  EXPECT_EQ(cell.line.connection, bus.line.connection);
  EXPECT_EQ(loaded.settings->guards[0].writer_hold, guard.writer_hold);
  EXPECT_EQ(loaded.settings->guards[0].quiet, guard.quiet);
  EXPECT_EQ(loaded.settings->guards[0].failsafe_grace, guard.failsafe_grace);
  EXPECT_EQ(loaded.settings->guards[0].failsafe_on_exit, guard.failsafe_on_exit);
}

/// What the file says is a default is one. Tests of `config/keys` look at the plain keys.
TEST(CompleteFile, ShowsTheDefaults) {
  const auto loaded = load_settings(kFolder + "mbgate.toml");
  ASSERT_TRUE(loaded.settings);
  const auto& shown = *loaded.settings;
  const gateway::ListenerSettings listener;
  const bus::BusSettings bus;
  EXPECT_EQ(shown.status_unit, gateway::Settings().status_unit);
  EXPECT_EQ(shown.http, gateway::HttpSettings());
  EXPECT_EQ(shown.listeners[0].address, listener.address);
  EXPECT_EQ(shown.listeners[0].port, listener.port);
  EXPECT_EQ(shown.listeners[1].broadcast_reply, listener.broadcast_reply);
  const auto& line = shown.buses[0];
  EXPECT_EQ(line.line.format, bus.line.format);
  EXPECT_EQ(line.line.rs485, bus.line.rs485);
  EXPECT_EQ(line.line.echo, bus.line.echo);
  EXPECT_EQ(line.line.paced, bus.line.paced);
  EXPECT_EQ(line.stop_deadline, bus::stop_deadline(bus));
  EXPECT_EQ(shown.guards.at(0).writer, gateway::WriterRule::any);
  EXPECT_EQ(shown.devices[0].profile.values.all().size(), 246U);
}

TEST(DemoFile, IsWhatTheDemoPromises) {
  const auto loaded = load_settings(kFolder + "demo.toml");
  EXPECT_EQ(render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  const auto& settings = *loaded.settings;
  ASSERT_EQ(settings.listeners.size(), 1U);
  EXPECT_EQ(settings.listeners[0].port, 1502);
  ASSERT_EQ(settings.buses.size(), 2U);
  EXPECT_EQ(settings.buses[0].line.device, "./line-a");
  EXPECT_EQ(settings.buses[0].line.baud, modbus::Baud{115200});
  EXPECT_EQ(settings.buses[1].line.device, "./line-b");
  EXPECT_EQ(settings.buses[1].line.baud, modbus::Baud{9600});
  ASSERT_EQ(settings.devices.size(), 4U);
  EXPECT_EQ(settings.devices[2].name, "turntable");
  EXPECT_EQ(settings.devices[2].timing.response_wait, 20ms);
  EXPECT_EQ(settings.devices[2].timing.response_timeout, 300ms);
  std::vector<std::string> profiles;
  profiles.reserve(settings.devices.size());
  for (const auto& device : settings.devices) {
    profiles.push_back(device.profile.name);
  }
  EXPECT_EQ(profiles,
            (std::vector<std::string>{"moons-st", "rs485-stepper", "autonics-aic", "moons-st"}));
  EXPECT_EQ(settings.devices[1].word_order, drive::WordOrder::little);
  EXPECT_EQ(settings.devices[3].word_order, drive::WordOrder::little);
  ASSERT_EQ(settings.routes.size(), 6U);
  EXPECT_TRUE(settings.routes[5].is_broadcast());
}

/// Complete configurations, each for a plant that its header describes.
std::vector<std::string> examples() {
  std::vector<std::string> names;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(MBGATE_SOURCE_DIR) + "/examples")) {
    if (entry.path().extension() == ".toml") {
      names.push_back(entry.path().stem());
    }
  }
  std::ranges::sort(names);
  return names;
}

TEST(Examples, AreAllThere) {
  EXPECT_THAT(examples(),
              testing::IsSupersetOf({"ethernet-and-rs485", "mixed-line", "moons-line"}));
}

class Example : public testing::TestWithParam<std::string> {};

TEST_P(Example, LoadsWithoutAWordAndSaysWhichPlantItIs) {
  const std::string path = std::string(MBGATE_SOURCE_DIR) + "/examples/" + GetParam() + ".toml";
  const auto loaded = load_settings(path);
  EXPECT_EQ(render(loaded.diagnostics), "");
  EXPECT_TRUE(loaded.settings);
  EXPECT_THAT(text_of(path), testing::HasSubstr("\n# The plant: "));
}

std::string example_name(const testing::TestParamInfo<std::string>& info) {
  std::string name = info.param;
  std::ranges::replace(name, '-', '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Files, Example, testing::ValuesIn(examples()), example_name);

}  // namespace
}  // namespace mbgate::config::shipped_files_test
