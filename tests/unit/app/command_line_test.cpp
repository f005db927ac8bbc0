// SPDX-License-Identifier: Apache-2.0
#include "app/command_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <vector>

namespace mbgate::app {
namespace {

std::variant<Options, int> parse(std::vector<const char*> arguments) {
  arguments.insert(arguments.begin(), "mbgated");
  return parse_command_line(static_cast<int>(arguments.size()), arguments.data(), "1.2.3");
}

TEST(CommandLine, HasTheInstalledConfigurationAsDefault) {
  const auto parsed = parse({});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  EXPECT_EQ(std::get<Options>(parsed).config, "/etc/mbgate/mbgate.toml");
  EXPECT_FALSE(std::get<Options>(parsed).check);
  EXPECT_FALSE(std::get<Options>(parsed).profiles);
  EXPECT_FALSE(std::get<Options>(parsed).record);
}

TEST(CommandLine, TakesAFileAndTheCheck) {
  const auto parsed = parse({"--config", "x.toml", "--check"});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  EXPECT_EQ(std::get<Options>(parsed).config, "x.toml");
  EXPECT_TRUE(std::get<Options>(parsed).check);
}

TEST(CommandLine, TakesAFolderOfProfilesThatIsThere) {
  const auto parsed = parse({"--profiles", MBGATE_SOURCE_DIR "/tests/config/profiles"});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  EXPECT_EQ(std::get<Options>(parsed).profiles, MBGATE_SOURCE_DIR "/tests/config/profiles");
  testing::internal::CaptureStderr();
  const auto missing = parse({"--profiles", "no-such-folder"});
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "--profiles: Directory does not exist: no-such-folder\n"
            "Run with --help for more information.\n");
  EXPECT_EQ(std::get<int>(missing), 64);
}

TEST(CommandLine, TakesAFileToRecordTo) {
  const auto parsed = parse({"--record", "plant.rec"});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  EXPECT_EQ(std::get<Options>(parsed).record, "plant.rec");
}

TEST(CommandLine, PrintsTheVersion) {
  testing::internal::CaptureStdout();
  const auto parsed = parse({"--version"});
  EXPECT_EQ(testing::internal::GetCapturedStdout(), "mbgated 1.2.3\n");
  EXPECT_EQ(std::get<int>(parsed), 0);
}

TEST(CommandLine, PrintsWhatKeysTake) {
  testing::internal::CaptureStdout();
  const auto parsed = parse({"--keys"});
  EXPECT_THAT(testing::internal::GetCapturedStdout(),
              testing::HasSubstr("[[bus]]\tburst\tan integer from 1 to 1000\t8\teverywhere\n"));
  EXPECT_EQ(std::get<int>(parsed), 0);
}

TEST(CommandLine, RefusesWhatItDoesNotKnow) {
  testing::internal::CaptureStderr();
  const auto parsed = parse({"--bogus"});
  EXPECT_EQ(
      testing::internal::GetCapturedStderr(),
      "The following argument was not expected: --bogus\nRun with --help for more information.\n");
  EXPECT_EQ(std::get<int>(parsed), 64);
}

}  // namespace
}  // namespace mbgate::app
