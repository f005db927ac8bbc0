// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../parsed_line.hpp"

namespace mbgate::ctl {
namespace {

using testing::HasSubstr;

TEST(ScanOptions, AsksTheUnitsOfMostDrivesUnlessToldOtherwise) {
  const auto plain = command<ScanCommand>("scan");
  EXPECT_EQ(plain.target.port, 502);
  EXPECT_EQ(plain.units.size(), 32U);
  EXPECT_EQ(plain.bus, "line-a");
  EXPECT_EQ(plain.folder, std::nullopt);
  EXPECT_EQ(plain.config, std::nullopt);
  EXPECT_FALSE(plain.json);
  EXPECT_TRUE(command<ScanCommand>("scan --json").json);
  const auto scan = command<ScanCommand>(
      "scan --host plant --port 1502 --timeout 8s --units 3,7-8 --bus hall-3 --config new.toml "
      "--profiles " MBGATE_SOURCE_DIR "/tests");
  EXPECT_EQ(scan.target.host, "plant");
  EXPECT_EQ(scan.target.port, 1502);
  EXPECT_EQ(scan.target.timeout, std::chrono::seconds(8));
  EXPECT_EQ(scan.units, (std::vector<std::uint8_t>{3, 7, 8}));
  EXPECT_EQ(scan.bus, "hall-3");
  EXPECT_EQ(scan.config, "new.toml");
  EXPECT_EQ(scan.folder, MBGATE_SOURCE_DIR "/tests");
}

TEST(ScanOptions, TakesNoUnitsThatABusCannotHaveAndNoOtherNames) {
  EXPECT_EQ(complaint("scan --units 0-3"),
            "mbgatectl: \"0-3\" is not a list of units: 1 to 254, like 5 or 1-32 or 1-8,17");
  EXPECT_EQ(complaint("scan --timeout 5"),
            "mbgatectl: \"5\" is not a time from 1ms to 1000h, like 500ms or 5s");
  EXPECT_EQ(complaint("scan --bus a/b"),
            "mbgatectl: --bus: expected 1 to 64 letters, digits, - _ .");
}

TEST(ScanOptions, ASerialPortIsTriedInTheUsualModesUnlessToldOtherwise) {
  EXPECT_FALSE(command<ScanCommand>("scan").port);
  const auto plain = command<ScanCommand>("scan --device /dev/ttyUSB0").port;
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->device, "/dev/ttyUSB0");
  ASSERT_EQ(plain->modes.size(), 15U);
  EXPECT_EQ(mode_text(plain->modes.front()), "9600 8E1");
  EXPECT_EQ(mode_text(plain->modes.back()), "57600 8O1");
  EXPECT_EQ(plain->wait, std::chrono::milliseconds(100));
  EXPECT_FALSE(plain->all_modes);
  const auto port = command<ScanCommand>(
                        "scan --device a --bauds 250000,9600 --parities none --stop-bits 1,2 "
                        "--wait 1s --all-modes")
                        .port;
  ASSERT_TRUE(port);
  ASSERT_EQ(port->modes.size(), 4U);
  EXPECT_EQ(mode_text(port->modes[1]), "250000 8N2");
  EXPECT_EQ(port->wait, std::chrono::seconds(1));
  EXPECT_TRUE(port->all_modes);
}

TEST(ScanOptions, ASerialPortHasNoServerAndOnlyItHasModes) {
  for (const auto* option : {"--host plant", "--port 1502", "--timeout 8s"}) {
    EXPECT_THAT(complaint("scan --device a " + std::string(option)), HasSubstr("excludes"))
        << option;
  }
  for (const auto* option :
       {"--bauds 9600", "--parities odd", "--stop-bits 2", "--wait 1s", "--all-modes"}) {
    EXPECT_THAT(complaint("scan " + std::string(option)), HasSubstr("requires --device")) << option;
  }
  EXPECT_EQ(complaint("scan --device a --parities mark"),
            "mbgatectl: \"mark\" is not a list of parities: even, none, odd, with commas");
  EXPECT_EQ(complaint("scan --device a --wait 0ms"),
            "mbgatectl: \"0ms\" is not a time from 1ms to 1000h, like 500ms or 5s");
}

}  // namespace
}  // namespace mbgate::ctl
