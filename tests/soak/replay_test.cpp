// SPDX-License-Identifier: Apache-2.0
// A recording in which other settings come is played again.
#include "soak/replay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "config/load.hpp"
#include "gateway/recording/record.hpp"
#include "support/gateway_harness.hpp"
#include "support/hex.hpp"

namespace mbgate::test {
namespace {

using namespace std::chrono_literals;
using gateway::Instant;

// One bus of this name, and a listener that leads to it.
std::string plant(const std::string& bus) {
  return "[[listen]]\nname = \"plant\"\nport = 0\nbus = \"" + bus + "\"\n[[bus]]\nname = \"" + bus +
         "\"\ndevice = \"/dev/ttyS0\"\n";
}

using Files = std::vector<gateway::ConfigFile>;

gateway::Settings settings_of(const Files& files) {
  std::vector<config::TextFile> read;
  for (const auto& file : files) {
    read.push_back({file.path, file.text});
  }
  return config::load_settings(read).settings.value();
}

class Recording {
 public:
  explicit Recording(const Files& config) : harness_(settings_of(config), Instant{1s}) {
    text_ = gateway::head_lines({"0", "", config, Instant{1s}});
    gateway::append_start(text_, Instant{1s});
    drain();
  }
  void input(const gateway::Input& input, Instant now) {
    gateway::append_line(text_, input, now);
    harness_.handle(input, now);
    drain();
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void drain() {
    harness_.drain([this](const gateway::Action& action) {
      gateway::append_line(text_, action, harness_.settings());
    });
  }
  GatewayHarness harness_;
  std::string text_;
};

gateway::ClientConnected a_client() {
  return {gateway::ClientId{0},
          {gateway::ListenerId{0}, *routing::ClientAddress::parse("192.0.2.1"), 0}};
}

// First one file, then two that share a table, the first without its last newline.
Recording with_other_settings() {
  const Files next{{"test.toml", "gateway.unit = 254\n" + plant("line-b") + "[http]"},
                   {"conf.d/own.toml", "[gateway]\nlock_memory = false\n"}};
  const std::string lines = gateway::config_lines(next);
  const gateway::Settings settings = settings_of(next);
  const auto request = unhex("0001 0000 0006 01 03 0000 0001");
  Recording recording({{"test.toml", plant("line-a")}});
  recording.input(gateway::LineOpened{gateway::BusId{0}}, Instant{2s});
  recording.input(a_client(), Instant{2s});
  recording.input(gateway::ClientBytes{gateway::ClientId{0}, request}, Instant{3s});
  recording.input(gateway::SettingsChanged{&settings, lines}, Instant{4s});
  recording.input(gateway::LineOpened{gateway::BusId{1}}, Instant{5s});
  return recording;
}

TEST(Replay, OtherSettingsStandInTheRecordingAndComeAgain) {
  const Recording recording = with_other_settings();
  EXPECT_NE(recording.text().find("| name = \"line-b\"\n"), std::string::npos);
  EXPECT_NE(recording.text().find("< report bus line-b is open\n"), std::string::npos);
  std::istringstream stream(recording.text());
  const ReplayOutcome outcome = replay(stream, std::nullopt);
  EXPECT_EQ(outcome.difference, "");
  EXPECT_EQ(outcome.inputs, 5U);
}

// The gateway's own unit is asked how many requests there were, before and after.
TEST(Replay, CountersAreClearedAgain) {
  const auto ask = unhex("0001 0000 0006 FF 04 0006 0002");
  const std::string cleared = "3000000000 clear\n";
  Recording recording({{"test.toml", plant("line-a")}});
  recording.input(a_client(), Instant{2s});
  recording.input(gateway::ClientBytes{gateway::ClientId{0}, ask}, Instant{2s});
  recording.input(gateway::ClientSent{gateway::ClientId{0}}, Instant{2s});
  recording.input(gateway::ClearCountersAsked{}, Instant{3s});
  recording.input(gateway::ClientBytes{gateway::ClientId{0}, ask}, Instant{4s});
  std::string text = recording.text();
  const auto place = text.find(cleared);
  ASSERT_NE(place, std::string::npos) << text;
  std::istringstream stream(text);
  EXPECT_EQ(replay(stream, std::nullopt).difference, "");
  text.erase(place, cleared.size());
  std::istringstream without(text);
  EXPECT_THAT(replay(without, std::nullopt).difference,
              testing::HasSubstr("recorded \"< send 0 000100000007FF040400000001\", the replay "
                                 "gives \"< send 0 000100000007FF040400000002\""));
}

TEST(Replay, OtherSettingsWithoutTheirConfigurationAreSaid) {
  std::string text = with_other_settings().text();
  const auto begin = text.rfind("config test.toml\n");
  text.erase(begin, text.find("4000000000 settings\n") - begin);
  std::istringstream stream(text);
  EXPECT_THAT(replay(stream, std::nullopt).difference,
              testing::EndsWith("no configuration stands before other settings"));
}

TEST(Replay, OnesThatAreNotValidAreSaid) {
  std::string text = with_other_settings().text();
  const std::string name = "| name = \"line-b\"";
  text.replace(text.find(name), name.size(), "| name = 5");
  std::istringstream stream(text);
  EXPECT_NE(replay(stream, std::nullopt).difference.find("is not valid here"), std::string::npos);
}

}  // namespace
}  // namespace mbgate::test
