// SPDX-License-Identifier: Apache-2.0
#include "config/keys/keys.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <set>
#include <sstream>

namespace mbgate::config {
namespace {

using Name = std::pair<std::string, std::string>;  // section and key

/// Each key of conf/mbgate.toml, commented out or not, and what stands behind its first "=".
std::map<Name, std::string> shown_keys() {
  std::ifstream file(MBGATE_SOURCE_DIR "/conf/mbgate.toml");
  std::map<Name, std::string> shown;
  std::string section;
  for (std::string line; std::getline(file, line);) {
    line.erase(0, line.starts_with("# ") ? 2 : 0);
    const auto equals = line.find(" = ");
    if (line.starts_with("[")) {
      section = line;
    } else if (equals != std::string::npos && line.find(' ') == equals) {
      shown.try_emplace({section, line.substr(0, equals)}, line.substr(equals + 3));
    }
  }
  return shown;
}

struct Listed {
  std::string section, key, range, by_default, lines;
};

std::vector<Listed> listed_keys() {
  std::istringstream text(list_keys());
  std::vector<Listed> all;
  for (std::string line; std::getline(text, line);) {
    std::istringstream fields(line);
    Listed& listed = all.emplace_back();
    for (auto* field :
         {&listed.section, &listed.key, &listed.range, &listed.by_default, &listed.lines}) {
      std::getline(fields, *field, '\t');
    }
  }
  return all;
}

/// Those of a device that it has from its bus are shown there.
bool is_shown_with_its_bus(const Listed& listed) {
  const std::set<std::string> inherited = {"stop_retries",  "quarantine",     "quarantine_max",
                                           "offline_after", "probe_interval", "probe_timeout"};
  return listed.section == "[[device]]" && inherited.contains(listed.key);
}

TEST(Keys, StandInTheCompleteFileWithTheirDefaults) {
  const auto shown = shown_keys();
  for (const auto& listed : listed_keys()) {
    if (is_shown_with_its_bus(listed)) {
      continue;
    }
    const auto entry = shown.find({listed.section, listed.key});
    ASSERT_NE(entry, shown.end()) << listed.section << " " << listed.key;
    // The device of the example has a timeout of its own.
    const bool is_example = listed.section == "[[device]]" && listed.key == "response_timeout";
    if (listed.by_default != "-" && !is_example) {
      EXPECT_TRUE(entry->second.starts_with(listed.by_default + " ") ||
                  entry->second == listed.by_default)
          << listed.key << " = " << entry->second << ", default " << listed.by_default;
    }
  }
}

TEST(Keys, AreListedWithWhatTheyTakeAndWhereTheyBelong) {
  EXPECT_THAT(
      list_keys(),
      testing::AllOf(
          testing::StartsWith("[gateway]\tlock_memory\ttrue or false\tfalse\teverywhere\n"),
          testing::HasSubstr("\n[[listen]]\tidle_timeout\t\"0s\" (off) or a duration from 10ms to "
                             "1000h\t\"0s\"\teverywhere\n"),
          testing::HasSubstr("\n[[bus]]\tframe_slack\ta duration from 1ms to 10s\t-\tmode = "
                             "\"rtu\"\n"),
          testing::HasSubstr("\n[[bus]]\tlow_latency\ttrue or false\ttrue\tserial ports of this "
                             "machine\n")));
}

TEST(Keys, AreListedOnce) {
  std::set<Name> names;
  for (const auto& listed : listed_keys()) {
    EXPECT_TRUE(names.emplace(listed.section, listed.key).second) << listed.key;
    EXPECT_FALSE(listed.lines.empty()) << listed.key;
  }
}

TEST(Keys, OfAKindOfLineThatIsUnknownBelongEverywhere) {
  auto document = TomlDocument::parse({TextFile{"x.toml", "baud = 9600\noutstanding = 4\n"}});
  auto table = document.root();
  bus::BusSettings settings;
  read_keys(table, bus_keys(), settings);
  EXPECT_EQ(settings.line.baud, modbus::Baud{9600});
  EXPECT_EQ(settings.outstanding, 4U);
}

TEST(Keys, TellWhereTheyBelong) {
  auto document =
      TomlDocument::parse({TextFile{"x.toml", "outstanding = 4\nidle_probe = \"4s\"\n"}});
  auto table = document.root();
  bus::BusSettings settings;
  read_keys(table, bus_keys(), settings, Lines::remote_rtu);
  EXPECT_EQ(settings.outstanding, 1U);
  EXPECT_EQ(settings.line.connection.idle_probe, std::chrono::seconds(4));
  EXPECT_EQ(render(document.finish()),
            "x.toml:1:15: error: outstanding: belongs to mode = \"tcp\": a serial line carries one "
            "request at a time\noutstanding = 4\n              ^\n");
}

}  // namespace
}  // namespace mbgate::config
