// SPDX-License-Identifier: Apache-2.0
// Drives with profiles behind the gateway, once as mbgate-sim has them and once as servers of
// libmodbus, which has no idea of drives: the same suite must hold for both.
#include <gtest/gtest.h>

#include "integration/plant.hpp"
#include "integration/rtu_server.hpp"

namespace mbgate::test {
namespace {

constexpr unsigned kMoons = 1;    // low word first
constexpr unsigned kStepper = 2;  // low word first
constexpr unsigned kWindow = 3;   // the MOONS' drive, registers moved
constexpr auto* kLines = R"(
[[listen]]
name = "plant"
port = 0
[[listen]]
name = "moons"
port = 0
bus = "line-a"
[[listen]]
name = "stepper"
port = 0
bus = "line-b"
[[device]]
name = "axis"
bus = "line-a"
address = 1
profile = "moons-st"
word_order = "little"
[[device]]
name = "feeder"
bus = "line-b"
address = 1
profile = "rs485-stepper"
[[route]]
unit = 1
device = "axis"
word_order = "big"
[[route]]
unit = 2
device = "feeder"
word_order = "big"
[[route]]
unit = 3
device = "axis"
word_order = "big"
[[route.registers]]
table = "holding"
from = 1000
count = 10
to = 27
[[route.registers]]
table = "input"
from = 0
count = 44
to = 60
to_table = "holding"
)";

constexpr auto* kSimulator = R"(
[[bus]]
name = "line-a"
link = "line-a"
baud = 115200
parity = "none"
[[bus]]
name = "line-b"
link = "line-b"
baud = 115200
parity = "none"
[[device]]
name = "axis"
bus = "line-a"
address = 1
model = "moons"
word_order = "little"
[[device]]
name = "feeder"
bus = "line-b"
address = 1
model = "stepper"
)";

enum class FarEnd { simulator, libmodbus };

class DriveSuite : public testing::TestWithParam<FarEnd> {
 protected:
  DriveSuite() {
    std::string line_a = "line-a";
    std::string line_b = "line-b";
    if (GetParam() == FarEnd::simulator) {
      simulator_.emplace("mbgate-sim", std::vector{folder_.write("sim.toml", kSimulator).string()},
                         Process::Options{folder_.path(), {}});
      simulator_->wait_for_line("ready");
    } else {
      line_a = servers_.emplace_back(std::make_unique<RtuServer>(1))->path();
      line_b = servers_.emplace_back(std::make_unique<RtuServer>(1))->path();
    }
    const auto bus = [](const std::string& name, const std::string& device) {
      return "[[bus]]\nname = \"" + name + "\"\ndevice = \"" + device +
             "\"\nbaud = 115200\nparity = \"none\"\necho = false\nlisten_first = \"0ms\"\n"
             "response_timeout = \"20s\"\n";
    };
    const auto config =
        folder_.write("mbgate.toml", kLines + bus("line-a", line_a) + bus("line-b", line_b));
    gateway_.emplace("mbgated", std::vector<std::string>{"--config", config.string()},
                     Process::Options{folder_.path(), {}});
  }

  /// The answer to one request, both without their headers.
  std::string ask(unsigned unit, std::string_view pdu, const std::string& listener = "plant") {
    TcpClient client(gateway_->port_of(listener));
    client.send(request(7, unit, pdu));
    const auto answer = client.receive();
    return answer && answer->size() > 7 ? text_of({answer->begin() + 7, answer->end()})
                                        : "no answer";
  }
  /// What the drive itself holds, through a transparent listener.
  std::string held(const std::string& listener, std::string_view pdu) {
    return ask(1, pdu, listener);
  }

 private:
  TemporaryFolder folder_;
  std::vector<std::unique_ptr<RtuServer>> servers_;
  std::optional<Process> simulator_;
  std::optional<Process> gateway_;
};

TEST_P(DriveSuite, HoldValuesInTheirOwnOrder) {
  EXPECT_EQ(ask(kMoons, "10 001E 0002 04 0003 0D40"), "10 00 1E 00 02");
  EXPECT_EQ(ask(kMoons, "03 001E 0002"), "03 04 00 03 0D 40");
  EXPECT_EQ(held("moons", "03 001E 0002"), "03 04 0D 40 00 03");
  EXPECT_EQ(ask(kStepper, "10 00D8 0002 04 0000 7530"), "10 00 D8 00 02");
  EXPECT_EQ(ask(kStepper, "03 00D8 0002"), "03 04 00 00 75 30");
  EXPECT_EQ(held("stepper", "03 00D8 0002"), "03 04 75 30 00 00");
}

TEST_P(DriveSuite, OnlyTheLongOfAMixedWriteIsExchanged) {
  EXPECT_EQ(ask(kMoons, "10 001B 0005 0A 0258 0258 00F0 0003 0D40"), "10 00 1B 00 05");
  EXPECT_EQ(held("moons", "03 001B 0005"), "03 0A 02 58 02 58 00 F0 0D 40 00 03");
  EXPECT_EQ(ask(kMoons, "03 001B 0005"), "03 0A 02 58 02 58 00 F0 00 03 0D 40");
}

TEST_P(DriveSuite, HalfAValueIsReadAndWritten) {
  EXPECT_EQ(ask(kMoons, "06 003C 0012"), "06 00 3C 00 12");  // the high word
  EXPECT_EQ(ask(kMoons, "06 003D 3456"), "06 00 3D 34 56");
  EXPECT_EQ(held("moons", "03 003C 0002"), "03 04 34 56 00 12");
  EXPECT_EQ(ask(kMoons, "03 003D 0001"), "03 02 34 56");
  EXPECT_EQ(ask(kMoons, "10 003D 0001 02 0001"), "90 03");
}

TEST_P(DriveSuite, LongReadsAreOneAnswer) {
  EXPECT_EQ(ask(kMoons, "10 0042 0002 04 0001 0002"), "10 00 42 00 02");
  const std::string answer = ask(kMoons, "03 0000 007D");
  ASSERT_EQ(answer.size(), 3U * (2 + 250) - 1) << answer;
  EXPECT_EQ(answer.substr(3 * (2 + 2 * 0x42), 11), "00 01 00 02");
}

TEST_P(DriveSuite, WindowsLeadToOtherPlacesAndTables) {
  EXPECT_EQ(ask(kWindow, "06 03E8 00F0"), "06 03 E8 00 F0");
  EXPECT_EQ(held("moons", "03 001B 0001"), "03 02 00 F0");
  EXPECT_EQ(ask(kMoons, "10 003C 0002 04 0001 0002"), "10 00 3C 00 02");
  EXPECT_EQ(ask(kWindow, "04 0000 0002"), "04 04 00 01 00 02");
  EXPECT_EQ(ask(kWindow, "04 002C 0001"), "84 02");
  EXPECT_EQ(ask(kWindow, "03 0000 0001"), "83 02");
}

TEST_P(DriveSuite, WhatTheDriveDoesNotHaveIsRefusedByTheGateway) {
  EXPECT_EQ(ask(kMoons, "04 0000 0001"), "84 01");
  EXPECT_EQ(ask(kStepper, "06 00D0 0001"), "86 03");  // half of a value that starts motion
  EXPECT_EQ(ask(kStepper, "06 0066 0005"), "86 01");  // its address
}

INSTANTIATE_TEST_SUITE_P(Drives, DriveSuite, testing::Values(FarEnd::simulator, FarEnd::libmodbus),
                         [](const auto& parameter) {
                           return parameter.param == FarEnd::simulator ? "OfTheSimulator"
                                                                       : "OfLibmodbus";
                         });

}  // namespace
}  // namespace mbgate::test
