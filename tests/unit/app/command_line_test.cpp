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
  EXPECT_FALSE(std::get<Options>(parsed).text);
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

TEST(CommandLine, TakesWhoIsAskedAboutWithTheCheck) {
  const auto parsed = parse({"--check", "--who", "10.0.0.5", "--unit", "11", "--write", "holding",
                             "124", "--count", "4", "--role", "", "--listener", "plant"});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  const auto& who = std::get<Options>(parsed).who;
  ASSERT_TRUE(who);
  EXPECT_EQ(who->client, "10.0.0.5");
  EXPECT_EQ(who->unit, 11U);
  EXPECT_EQ(who->write, (std::vector<std::string>{"holding", "124"}));
  EXPECT_EQ(who->count, 4U);
  EXPECT_EQ(who->role, "");
  EXPECT_EQ(who->listener, "plant");
  testing::internal::CaptureStderr();
  EXPECT_EQ(std::get<int>(parse({"--who", "10.0.0.5", "--unit", "1"})), 64);
  EXPECT_EQ(std::get<int>(parse({"--check", "--who", "10.0.0.5"})), 64);
  testing::internal::GetCapturedStderr();
}

TEST(CommandLine, TakesASerialPortInPlaceOfAFile) {
  const auto parsed = parse({"--serial", "/dev/ttyUSB0", "--baud", "115200", "--parity", "none"});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  const auto& options = std::get<Options>(parsed);
  EXPECT_EQ(options.config, "--serial");
  EXPECT_EQ(options.text, serial_config({.device = "/dev/ttyUSB0",
                                         .baud = 115200,
                                         .parity = "none",
                                         .listen = *parse_listen("127.0.0.1:1502", {})}));
  EXPECT_FALSE(options.check);
  EXPECT_FALSE(options.print);
}

TEST(CommandLine, TakesWhereClientsConnectAndWhoMay) {
  const auto parsed = parse({"--serial", "/dev/ttyS0", "--stop-bits", "2", "--listen", "[::]:502",
                             "--allow", "10.0.0.0/8", "--allow", "fd00::/8", "--print-config"});
  ASSERT_TRUE(std::holds_alternative<Options>(parsed));
  EXPECT_EQ(std::get<Options>(parsed).text,
            serial_config({.device = "/dev/ttyS0",
                           .stop_bits = 2,
                           .listen = *parse_listen("[::]:502", {"::1"}),
                           .allow = {"10.0.0.0/8", "fd00::/8"}}));
  EXPECT_TRUE(std::get<Options>(parsed).print);
}

/// What is said of a wrong command line.
std::string refusal(const std::vector<const char*>& arguments) {
  testing::internal::CaptureStderr();
  const auto parsed = parse(arguments);
  std::string said = testing::internal::GetCapturedStderr();
  EXPECT_EQ(std::get<int>(parsed), 64) << said;
  return said;
}

TEST(CommandLine, RefusesASerialPortWithAFile) {
  EXPECT_EQ(refusal({"--serial", "/dev/ttyUSB0", "--config", "x.toml"}),
            "--serial: takes the place of a configuration file: leave out --config\n"
            "Run with --help for more information.\n");
}

TEST(CommandLine, RefusesToOpenASerialPortToEveryone) {
  EXPECT_EQ(refusal({"--serial", "/dev/ttyUSB0", "--listen", "0.0.0.0:1502"}),
            "--listen: other machines can reach 0.0.0.0: add --allow with the permitted clients, "
            "such as --allow 192.168.10.0/24\n"
            "Run with --help for more information.\n");
}

TEST(CommandLine, RefusesOptionsOfASerialPortWithoutOne) {
  const std::vector<std::vector<const char*>> wrong = {
      {"--baud", "9600"},         {"--parity", "none"},    {"--stop-bits", "2"},
      {"--listen", "[::1]:1502"}, {"--allow", "10.0.0.7"}, {"--print-config"}};
  for (const auto& arguments : wrong) {
    EXPECT_EQ(refusal(arguments), std::string(arguments[0]) +
                                      " requires --serial\nRun with --help for more "
                                      "information.\n");
  }
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
