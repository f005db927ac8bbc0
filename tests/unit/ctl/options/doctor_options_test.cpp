// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "../parsed_line.hpp"

namespace mbgate::ctl {
namespace {

using testing::HasSubstr;

TEST(DoctorOptions, ExaminesTheOnlyBusUnlessToldOtherwise) {
  const auto plain = command<DoctorCommand>("doctor");
  EXPECT_FALSE(plain.port);
  EXPECT_EQ(plain.bus, "");
  EXPECT_EQ(plain.config, "/etc/mbgate/mbgate.toml");
  EXPECT_TRUE(plain.units.empty());
  EXPECT_EQ(plain.holding_register, 0);
  EXPECT_EQ(plain.requests, 20U);
  EXPECT_EQ(plain.listen, std::chrono::seconds(2));
  EXPECT_FALSE(plain.json);
  const auto doctor = command<DoctorCommand>(
      "doctor --bus line-a --config new.toml --address 3,7-8 --register 0x1E --requests 5 --listen "
      "500ms --json --profiles " MBGATE_SOURCE_DIR "/tests");
  EXPECT_EQ(doctor.bus, "line-a");
  EXPECT_EQ(doctor.config, "new.toml");
  EXPECT_EQ(doctor.folder, MBGATE_SOURCE_DIR "/tests");
  EXPECT_EQ(doctor.units, (std::vector<std::uint8_t>{3, 7, 8}));
  EXPECT_EQ(doctor.holding_register, 30);
  EXPECT_EQ(doctor.requests, 5U);
  EXPECT_EQ(doctor.listen, std::chrono::milliseconds(500));
  EXPECT_TRUE(doctor.json);
}

TEST(DoctorOptions, APortHasTheDefaultsOfABus) {
  const auto plain = command<DoctorCommand>("doctor --device /dev/ttyUSB0").port;
  ASSERT_TRUE(plain);
  EXPECT_EQ(plain->device, "/dev/ttyUSB0");
  EXPECT_EQ(mode_text(plain->mode), "19200 8E1");
  EXPECT_EQ(plain->timeout, std::chrono::seconds(1));
  const auto port =
      command<DoctorCommand>(
          "doctor --device a --baud 115200 --parity none --stop-bits 2 --timeout 300ms")
          .port;
  ASSERT_TRUE(port);
  EXPECT_EQ(mode_text(port->mode), "115200 8N2");
  EXPECT_EQ(port->timeout, std::chrono::milliseconds(300));
}

TEST(DoctorOptions, APortIsNotABusOfAConfiguration) {
  for (const auto* option : {"--bus a", "--config a"}) {
    EXPECT_THAT(complaint("doctor --device a " + std::string(option)), HasSubstr("excludes"));
  }
  for (const auto* option : {"--baud 9600", "--parity odd", "--stop-bits 2", "--timeout 1s"}) {
    EXPECT_THAT(complaint("doctor " + std::string(option)), HasSubstr("requires --device"));
  }
}

TEST(DoctorOptions, SayWhatIsWrong) {
  EXPECT_EQ(complaint("doctor --device a --baud 9600,19200"),
            "mbgatectl: one rate, one parity, and 1 or 2 stop bits: no lists");
  EXPECT_EQ(complaint("doctor --device a --parity mark"),
            "mbgatectl: \"mark\" is not a list of parities: even, none, odd, with commas");
  EXPECT_EQ(complaint("doctor --device a --timeout 0ms"),
            "mbgatectl: \"0ms\" is not a time from 1ms to 1000h, like 500ms or 5s");
  EXPECT_EQ(complaint("doctor --listen 2"),
            "mbgatectl: \"2\" is not a time from 1ms to 1000h, like 500ms or 5s");
  EXPECT_EQ(complaint("doctor --address 0"),
            "mbgatectl: \"0\" is not a list of units: 1 to 254, like 5 or 1-32 or 1-8,17");
}

}  // namespace
}  // namespace mbgate::ctl
