// SPDX-License-Identifier: Apache-2.0
// A recording in which other settings come is played again, as it is and with one line changed.
#include "ctl/replay/replay.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>

#include "config/load.hpp"
#include "ctl/request/carry_out.hpp"
#include "report/recording/record.hpp"
#include "support/gateway_harness.hpp"
#include "support/hex.hpp"

namespace mbgate::ctl {
namespace {

using namespace std::chrono_literals;
using gateway::Instant;

// One bus of this name, and a listener that leads to it.
std::string recorded_plant(const std::string& bus) {
  return "[[listen]]\nname = \"plant\"\nport = 0\nbus = \"" + bus + "\"\n[[bus]]\nname = \"" + bus +
         "\"\ndevice = \"/dev/ttyS0\"\n";
}

using Files = std::vector<report::ConfigFile>;

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
    text_ = report::head_lines({"0", "", config, Instant{1s}});
    report::append_start(text_, Instant{1s});
    drain();
  }
  void input(const gateway::Input& input, Instant now) {
    report::append_line(text_, input, now);
    harness_.handle(input, now);
    drain();
  }
  [[nodiscard]] const std::string& text() const { return text_; }

 private:
  void drain() {
    harness_.drain([this](const gateway::Action& action) {
      report::append_line(text_, action, harness_.settings());
    });
  }
  test::GatewayHarness harness_;
  std::string text_;
};

gateway::ClientConnected a_client() {
  return {gateway::ClientId{0},
          {gateway::ListenerId{0}, *routing::ClientAddress::parse("192.0.2.1")}};
}

// First one file, then two that share a table, the first without its last newline.
Recording with_other_settings() {
  const Files next{{"test.toml", "gateway.unit = 254\n" + recorded_plant("line-b") + "[http]"},
                   {"conf.d/own.toml", "[gateway]\nlock_memory = false\n"}};
  const std::string lines = report::config_lines(next);
  const gateway::Settings settings = settings_of(next);
  const auto request = test::unhex("0001 0000 0006 01 03 0000 0001");
  Recording recording({{"test.toml", recorded_plant("line-a")}});
  recording.input(gateway::LineOpened{gateway::BusId{0}}, Instant{2s});
  recording.input(a_client(), Instant{2s});
  recording.input(gateway::ClientBytes{gateway::ClientId{0}, request}, Instant{3s});
  recording.input(gateway::SettingsChanged{&settings, lines}, Instant{4s});
  recording.input(gateway::LineOpened{gateway::BusId{1}}, Instant{5s});
  return recording;
}

/// The recording with `found` replaced, which must be in it; the last one of them.
std::string changed(const std::string& found, const std::string& wanted) {
  std::string text = with_other_settings().text();
  const auto at = text.rfind(found);
  EXPECT_NE(at, std::string::npos) << found;
  return at == std::string::npos ? text : text.replace(at, found.size(), wanted);
}

/// The number of the line that is the last one to begin so.
std::size_t line_of(const std::string& text, const std::string& begin) {
  const auto at = text.rfind("\n" + begin);
  EXPECT_NE(at, std::string::npos) << begin;
  return 2 + static_cast<std::size_t>(std::ranges::count(text.substr(0, at), '\n'));
}

ReplayOutcome replayed(const std::string& text) {
  std::istringstream stream(text);
  return replay(stream);
}

/// What is wrong with a recording, and its line.
void expect_bad(const std::string& text, const std::string& begin_of_line,
                const std::string& reason) {
  const auto outcome = replayed(text);
  ASSERT_TRUE(outcome.bad);
  EXPECT_EQ(outcome.bad->reason, reason);
  EXPECT_EQ(outcome.bad->line, line_of(text, begin_of_line));
  EXPECT_FALSE(outcome.difference);
}

TEST(Replay, OtherSettingsStandInTheRecordingAndComeAgain) {
  const std::string text = with_other_settings().text();
  EXPECT_NE(text.find("| name = \"line-b\"\n"), std::string::npos);
  EXPECT_NE(text.find("< report bus line-b is open\n"), std::string::npos);
  const ReplayOutcome outcome = replayed(text);
  EXPECT_FALSE(outcome.bad);
  EXPECT_FALSE(outcome.difference);
  EXPECT_EQ(outcome.inputs, 5U);
  EXPECT_EQ(outcome.version, "0");
}

// The status unit is asked how many requests there were, before and after.
TEST(Replay, CountersAreClearedAgain) {
  const auto ask = test::unhex("0001 0000 0006 FF 04 0006 0002");
  const std::string cleared = "3000000000 clear\n";
  Recording recording({{"test.toml", recorded_plant("line-a")}});
  recording.input(a_client(), Instant{2s});
  recording.input(gateway::ClientBytes{gateway::ClientId{0}, ask}, Instant{2s});
  recording.input(gateway::ClientSent{gateway::ClientId{0}}, Instant{2s});
  recording.input(gateway::ClearCountersAsked{}, Instant{3s});
  recording.input(gateway::ClientBytes{gateway::ClientId{0}, ask}, Instant{4s});
  std::string text = recording.text();
  const auto place = text.find(cleared);
  ASSERT_NE(place, std::string::npos) << text;
  EXPECT_FALSE(replayed(text).difference);
  text.erase(place, cleared.size());
  const auto without = replayed(text).difference;
  ASSERT_TRUE(without);
  EXPECT_EQ(without->recorded, "< send 0 000100000007FF040400000001");
  EXPECT_EQ(without->replayed, "< send 0 000100000007FF040400000002");
}

TEST(Replay, NamesTheFirstActionThatIsAnother) {
  const std::string text = changed("< report bus line-b is open", "< report bus line-b is gone");
  const auto outcome = replayed(text);
  EXPECT_FALSE(outcome.bad);
  ASSERT_TRUE(outcome.difference);
  EXPECT_EQ(outcome.difference->line, line_of(text, "< report bus line-b is gone"));
  EXPECT_EQ(outcome.difference->input, "5000000000 opened 1 virtual");
  EXPECT_EQ(outcome.difference->recorded, "< report bus line-b is gone");
  EXPECT_EQ(outcome.difference->replayed, "< report bus line-b is open");
}

TEST(Replay, NamesAnActionThatIsNotDoneAnyMore) {
  const std::string text = with_other_settings().text() + "< report there was more\n";
  const auto outcome = replayed(text);
  ASSERT_TRUE(outcome.difference);
  EXPECT_EQ(outcome.difference->line, line_of(text, "< report there was more"));
  EXPECT_EQ(outcome.difference->replayed, "nothing");
}

TEST(Replay, OtherSettingsWithoutTheirConfigurationAreSaid) {
  std::string text = with_other_settings().text();
  const auto begin = text.rfind("config test.toml\n");
  text.erase(begin, text.find("4000000000 settings\n") - begin);
  expect_bad(text, "4000000000 settings", "expected a configuration before the new settings");
}

TEST(Replay, OnesThatAreNotValidAreSaid) {
  expect_bad(changed("| device = \"/dev/ttyS0\"", "| device = 5"), "4000000000 settings",
             "expected a configuration that this version accepts, but:\n"
             "test.toml:8:10: error: device: expected a string, found 5\n"
             "device = 5\n"
             "         ^");
}

// Settings that come before everything is done are no recorded gateway's.
TEST(Replay, NamesAnActionThatIsNotInTheRecordingBeforeOtherSettings) {
  std::string text = with_other_settings().text();
  const auto begin = text.rfind("\n< ", text.find("4000000000 settings\n")) + 1;
  const auto end = text.find('\n', begin);
  const std::string action = text.substr(begin, end - begin);
  text.erase(begin, action.size() + 1);
  const auto outcome = replayed(text);
  EXPECT_FALSE(outcome.bad);
  ASSERT_TRUE(outcome.difference);
  EXPECT_EQ(outcome.difference->line, line_of(text, "4000000000 settings"));
  EXPECT_EQ(outcome.difference->input, "3000000000 read 0 0 000100000006010300000001");
  EXPECT_EQ(outcome.difference->recorded, "nothing more");
  EXPECT_EQ(outcome.difference->replayed, action);
}

TEST(Replay, SaysThatItCannotStartThen) {
  for (const std::string start : {"-1", "4611686018427387904", "9223372036854775807"}) {
    expect_bad(changed("1000000000 start", start + " start"), start + " start",
               "expected an instant from 0 to 4611686018427387903, found " + start);
  }
}

TEST(Replay, SaysWhatIsNoRecording) {
  const auto outcome = replayed("[[listen]]\n");
  ASSERT_TRUE(outcome.bad);
  EXPECT_EQ(outcome.bad->reason, "expected \"mbgate recording 1\": this is not a recording");
  EXPECT_EQ(outcome.bad->line, 1U);
}

TEST(Replay, SaysThatARecordingEndsWithinItsHead) {
  const auto outcome = replayed("mbgate recording 1\nversion 0\n");
  ASSERT_TRUE(outcome.bad);
  EXPECT_EQ(outcome.bad->reason,
            "expected the line that ends with \"start\", but the recording ends before it");
  EXPECT_EQ(outcome.bad->line, 3U);
}

TEST(Replay, SaysWhichInputIsNone) {
  expect_bad(changed("opened 1 virtual", "opened 1 imaginary"), "5000000000 opened",
             "expected uart, adapter or virtual, found \"imaginary\"");
  expect_bad(changed("opened 1 virtual", "opened 7 virtual"), "5000000000 opened",
             "expected a bus or a listener that the recorded configuration has, found "
             "\"5000000000 opened 7 virtual\"");
  expect_bad(changed("5000000000 opened", "3999999999 opened"), "3999999999 opened",
             "expected an instant from 4000000000 to 4611686018427387903, found 3999999999");
  expect_bad(changed("5000000000 opened", "4611686018427387904 opened"),
             "4611686018427387904 opened",
             "expected an instant from 4000000000 to 4611686018427387903, found "
             "4611686018427387904");
}

/// What the command prints of a recording in a file of its own.
class ReplayCommandPrints : public testing::Test {
 protected:
  ReplayCommandPrints()
      : file_(testing::TempDir() + "mbgate-" + std::to_string(getpid()) + ".rec") {}
  void TearDown() override { std::filesystem::remove(file_); }
  int run(const std::string& text) {
    std::ofstream(file_, std::ios::binary) << text;
    return run_file(file_);
  }
  int run_file(const std::string& file) {
    std::ostringstream out;
    std::ostringstream errors;
    const int status = carry_out(ReplayCommand{file, {}}, out, errors);
    printed_ = out.str();
    errors_ = errors.str();
    return status;
  }
  std::string file_;
  std::string printed_;
  std::string errors_;
};

TEST_F(ReplayCommandPrints, ThatAllIsTheSame) {
  EXPECT_EQ(run(with_other_settings().text()), 0);
  EXPECT_EQ(errors_, "");
  EXPECT_EQ(printed_, "same actions at every input: 5 inputs, 6 actions, recorded by mbgated 0\n");
  EXPECT_EQ(run(with_other_settings().text() + "end it cannot be written: No space left\n"), 0);
  EXPECT_EQ(
      printed_,
      "same actions at every input: 5 inputs, 6 actions, recorded by mbgated 0; the recording "
      "ended before the gateway did: it cannot be written: No space left\n");
}

TEST_F(ReplayCommandPrints, TheFirstDifference) {
  const std::string text = changed("< report bus line-b is open", "< report bus line-b is gone");
  EXPECT_EQ(run(text), 1);
  EXPECT_EQ(errors_, "");
  EXPECT_EQ(printed_, file_ + ":" + std::to_string(line_of(text, "< report bus line-b")) +
                          ": different, after 5 inputs and 5 actions that were the same\n"
                          "the last input:    5000000000 opened 1 virtual\n"
                          "recorded:          < report bus line-b is gone\n"
                          "this version does: < report bus line-b is open\n");
}

TEST_F(ReplayCommandPrints, ThePlaceOfWhatIsWrong) {
  const std::string text = changed("5000000000 opened", "5000000000 uncorked");
  EXPECT_EQ(run(text), 78);
  EXPECT_EQ(printed_, "");
  EXPECT_EQ(errors_, file_ + ":" + std::to_string(line_of(text, "5000000000 uncorked")) +
                         ": error: expected an input, found \"uncorked\"\n");
}

TEST_F(ReplayCommandPrints, ThatThereIsNoFile) {
  EXPECT_EQ(run_file("no-such-folder/plant.rec"), 78);
  EXPECT_EQ(errors_,
            "no-such-folder/plant.rec: error: cannot be read: No such file or directory\n");
  EXPECT_EQ(run_file(testing::TempDir()), 78);
  EXPECT_EQ(errors_, testing::TempDir() + ": error: cannot be read: Is a directory\n");
}

}  // namespace
}  // namespace mbgate::ctl
