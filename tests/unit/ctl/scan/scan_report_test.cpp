// SPDX-License-Identifier: Apache-2.0
#include "ctl/scan/scan_report.hpp"

#include <gtest/gtest.h>

#include "found_units.hpp"

namespace mbgate::ctl {
namespace {

using namespace std::chrono_literals;

TEST(ScanTable, HasALineForEachUnitAndExplainsItself) {
  EXPECT_EQ(
      scan_table(plant()),
      "  unit  functions  slowest  profile                  answers that fit                  "
      "word order  texts\n"
      "  1     03         4ms      moons-st                 9 of 9                            "
      "unknown     -\n"
      "  3     03         4ms      moons-m3                 9 of 9                            "
      "little      -\n"
      "  4     03         4ms      moons-ssdc or moons-stb  9 of 9                            "
      "big         -\n"
      "  17    03         4ms      autonics-aic             9 of 9                            "
      "big         model name \"AiC-D-56LA\"\n"
      "  32    03         120ms    generic                  4 of 9 for moons-m2, then silent  "
      "-           -\n"
      "Profiles joined by \"or\" cannot be told apart by reading.\n"
      "Where the profile is generic, none fits; the nearest one is named.\n");
}

TEST(StartingConfig, LeavesTheChoiceWhereReadingCannotTell) {
  EXPECT_EQ(
      starting_config({"plant.example", 1502, 1, 5s}, "line-b", plant().found),
      R"(# What mbgatectl scan found at plant.example, port 1502. Check every line before you use
# it: a scan only reads, and what it cannot find out is marked CHOOSE.

[[listen]]
name = "plant"
address = "127.0.0.1"          # CHOOSE: the address that the clients use, and `allow`, the permitted clients
port = 502

[[bus]]
name = "line-b"
device = "/dev/ttyUSB0"        # CHOOSE: better a name in /dev/serial/by-id
baud = 19200                   # CHOOSE these three as the line is set now
parity = "even"
stop_bits = 1

[[device]]
name = "unit-1"
bus = "line-b"
address = 1
profile = "moons-st"  # MOONS' step drives ST, STAC, STM and SWM; 9 of 9 answers fit
# CHOOSE the setting of the drive, which cannot be read.
# word_order = "big"  # or "little"

[[route]]
unit = 1
device = "unit-1"
# word_order = "big"  # once the choice above is made: what the clients see

[[device]]
name = "unit-3"
bus = "line-b"
address = 3
profile = "moons-m3"  # MOONS' servo drives M3; 9 of 9 answers fit
word_order = "little"

[[route]]
unit = 3
device = "unit-3"
word_order = "big"

[[device]]
name = "unit-4"
bus = "line-b"
address = 4
# CHOOSE one: reading cannot tell them apart, and their values differ.
# profile = "moons-ssdc"  # MOONS' step drives SSDC, SS, RS, SSM, TSM and TXM
# profile = "moons-stb"  # MOONS' step drives STB
# word_order = "big"  # as read

[[route]]
unit = 4
device = "unit-4"
# word_order = "big"  # once the choice above is made: what the clients see

# model name: "AiC-D-56LA"
[[device]]
name = "unit-17"
bus = "line-b"
address = 17
profile = "autonics-aic"  # Autonics AiC closed-loop stepper drives; 9 of 9 answers fit
word_order = "big"

[[route]]
unit = 17
device = "unit-17"
word_order = "big"

[[device]]
name = "unit-32"
bus = "line-b"
address = 32
# No profile fits: generic limits, no 32-bit values. A profile can be written for it.
profile = "generic"

[[route]]
unit = 32
device = "unit-32"
)");
}

TEST(StartingConfig, HasTheLineAsItWasFound) {
  const LineMode mode{modbus::Baud{115200}, {8, modbus::Parity::none, 2}};
  const std::string begin =
      R"(# What mbgatectl scan found at /dev/ttyUSB1. Check every line before you use
# it: a scan only reads, and what it cannot find out is marked CHOOSE.

[[listen]]
name = "plant"
address = "127.0.0.1"          # CHOOSE: the address that the clients use, and `allow`, the permitted clients
port = 502

[[bus]]
name = "line-b"
device = "/dev/ttyUSB1")";
  const std::string rest = R"(
baud = 115200  # the units answered with these three
parity = "none"
stop_bits = 2
)";
  EXPECT_EQ(starting_config(FoundLine{"/dev/ttyUSB1", std::nullopt, mode}, "line-b", {}),
            begin + rest);
  EXPECT_EQ(
      starting_config(FoundLine{"/dev/ttyUSB1", "/dev/serial/by-id/usb-1", mode}, "line-b", {}),
      begin + "  # CHOOSE: better \"/dev/serial/by-id/usb-1\", which stays the same" + rest);
}

TEST(LineHead, StandsAboveTheTable) {
  EXPECT_EQ(line_head({"/dev/ttyUSB0", std::nullopt, {modbus::Baud{9600}, {}}}),
            "/dev/ttyUSB0, 9600 baud, parity even, stop bits 1:\n");
}

TEST(StartingConfig, HasARoundTimeoutThatIsAtLeastThriceTheSlowestAnswer) {
  const auto has_timeout = [](std::chrono::milliseconds slowest, const std::string& timeout) {
    FoundUnit unit = plant().found.back();
    unit.slowest = slowest;
    const auto text = starting_config(FoundLine{"/dev/ttyUSB1"}, "line-b", {unit});
    return text.find("\nresponse_timeout = \"" + timeout + "\"  #") != std::string::npos;
  };
  EXPECT_TRUE(has_timeout(1ms, "100ms"));
  EXPECT_TRUE(has_timeout(33ms, "100ms"));
  EXPECT_TRUE(has_timeout(34ms, "200ms"));
  EXPECT_TRUE(has_timeout(400ms, "2s"));
  EXPECT_TRUE(has_timeout(4100ms, "13s"));
}

TEST(StartingConfig, LeavesTheTimeoutToAProfileThatHasALongerOne) {
  const auto has_timeout = [](std::chrono::milliseconds slowest) {
    FoundUnit unit = plant().found.front();
    unit.slowest = slowest;
    const auto text = starting_config(FoundLine{"/dev/ttyUSB1"}, "line-b", {unit});
    return text.find("response_timeout") != std::string::npos;
  };
  EXPECT_FALSE(has_timeout(300ms));
  EXPECT_TRUE(has_timeout(301ms));
}

}  // namespace
}  // namespace mbgate::ctl
