// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "app/command_line.hpp"
#include "support/config_text.hpp"

namespace mbgate::app {
namespace {

const std::vector<std::string> kNobodyElse;
const ListenAddress kLocal = *parse_listen("127.0.0.1:1502", kNobodyElse);

config::Loaded load_serial(const SerialOptions& options) {
  return test::load_settings_text("--serial", serial_config(options));
}

std::string listen_text(const Result<ListenAddress, std::string>& listen) {
  return listen ? listen->address.to_text() + " " + std::to_string(listen->port) : listen.error();
}

TEST(SerialConfig, IsOneBusAndATransparentListener) {
  EXPECT_EQ(serial_config({.device = "/dev/ttyUSB0",
                           .baud = 115200,
                           .parity = "none",
                           .stop_bits = 2,
                           .listen = *parse_listen("[::]:502", {"fd00::7"}),
                           .allow = {"192.168.10.0/24", "fd00::7"}}),
            "# What mbgated --serial serves. mbgate.toml(5) has every key.\n"
            "\n"
            "[[listen]]\n"
            "name = \"clients\"\n"
            "address = \"::\"\n"
            "port = 502\n"
            "bus = \"line\"\n"
            "allow = [\"192.168.10.0/24\", \"fd00::7\"]\n"
            "\n"
            "[[bus]]\n"
            "name = \"line\"\n"
            "device = \"/dev/ttyUSB0\"\n"
            "baud = 115200\n"
            "parity = \"none\"\n"
            "stop_bits = 2\n");
}

TEST(SerialConfig, HasTheDefaultsOfTheConfiguration) {
  const auto loaded = load_serial({.device = "/dev/ttyUSB0", .listen = kLocal});
  EXPECT_EQ(config::render(loaded.diagnostics), "");
  ASSERT_TRUE(loaded.settings);
  ASSERT_EQ(loaded.settings->buses.size(), 1U);
  bus::LineSettings line;
  line.device = "/dev/ttyUSB0";
  EXPECT_EQ(loaded.settings->buses[0].line, line);
  ASSERT_EQ(loaded.settings->listeners.size(), 1U);
  const auto& listener = loaded.settings->listeners[0];
  EXPECT_EQ(listener.address, "127.0.0.1");
  EXPECT_EQ(listener.port, 1502);
  EXPECT_EQ(listener.bus, drive::BusId{0});
  EXPECT_TRUE(listener.allow.empty());
}

TEST(SerialConfig, QuotesWhateverAPathHolds) {
  for (const std::string device :
       {"/dev/with \"quotes\"", "C:\\COM1", "\"\n[[route]]\nunit = 1\n#", "\x01\t\x7F'''",
        "/dev/Stra\xC3\x9F"
        "e"}) {
    const auto loaded = load_serial({.device = "/dev/" + device, .listen = kLocal});
    EXPECT_EQ(config::render(loaded.diagnostics), "");
    ASSERT_TRUE(loaded.settings) << device;
    EXPECT_EQ(loaded.settings->buses[0].line.device, "/dev/" + device);
  }
  EXPECT_THAT(serial_config({.device = "\"\\\n\x7F"}),
              testing::HasSubstr("device = \"\\\"\\\\\\u000A\\u007F\"\n"));
}

TEST(SerialConfig, IsCheckedAsAFileIs) {
  const auto loaded = load_serial({.device = "/dev/ttyUSB0",
                                   .baud = 0,
                                   .parity = "some",
                                   .stop_bits = 3,
                                   .listen = kLocal,
                                   .allow = {"10.0.0.1/8"}});
  EXPECT_FALSE(loaded.settings);
  EXPECT_EQ(
      config::render(loaded.diagnostics),
      "--serial:8:10: error: allow: expected an address or a block without bits beyond its "
      "prefix, such as \"192.168.10.0/24\", found \"10.0.0.1/8\"\n"
      "allow = [\"10.0.0.1/8\"]\n"
      "         ^\n"
      "--serial:13:8: error: baud: expected an integer from 1 to 4294967295, found 0\n"
      "baud = 0\n"
      "       ^\n"
      "--serial:14:10: error: parity: expected \"none\", \"even\" or \"odd\", found \"some\"\n"
      "parity = \"some\"\n"
      "         ^\n"
      "--serial:15:13: error: stop_bits: expected an integer from 1 to 2, found 3\n"
      "stop_bits = 3\n"
      "            ^\n");
}

TEST(ParseListen, TakesLoopbackAddressesOfBothFamilies) {
  EXPECT_EQ(listen_text(parse_listen("127.0.0.1:1502", kNobodyElse)), "127.0.0.1 1502");
  EXPECT_EQ(listen_text(parse_listen("127.8.0.1:0", kNobodyElse)), "127.8.0.1 0");
  EXPECT_EQ(listen_text(parse_listen("[::1]:65535", kNobodyElse)), "::1 65535");
  EXPECT_EQ(listen_text(parse_listen("[::ffff:127.0.0.1]:502", kNobodyElse)), "127.0.0.1 502");
}

TEST(ParseListen, RefusesWhatIsNoAddressAndPort) {
  for (const char* text :
       {"", ":", "1502", "127.0.0.1", "127.0.0.1:", "127.0.0.1:x", "127.0.0.1:65536",
        "127.0.0.1:-1", "localhost:1502", "::1:1502", "[::1]", "[127.0.0.1]:1502", "[]:1502",
        "[:1502", "127.0.0.1 :1502", "[fe80::1%eth0]:1502"}) {
    EXPECT_EQ(listen_text(parse_listen(text, kNobodyElse)),
              "expected an IPv4 or IPv6 address and a port, such as 127.0.0.1:1502 or "
              "[::1]:1502, found \"" +
                  std::string(text) + "\"");
  }
}

TEST(ParseListen, MustKnowWhoMayConnectFromOtherMachines) {
  for (const std::string address :
       {"192.168.10.2", "0.0.0.0", "128.0.0.1", "::", "::2", "fe80::1"}) {
    const bool v6 = address.find(':') != std::string::npos;
    const std::string text = (v6 ? "[" + address + "]" : address) + ":1502";
    EXPECT_EQ(listen_text(parse_listen(text, kNobodyElse)),
              "other machines can reach " + address +
                  ": add --allow with the permitted clients, such as --allow 192.168.10.0/24");
    EXPECT_EQ(listen_text(parse_listen(text, {"10.0.0.7"})), address + " 1502");
  }
}

}  // namespace
}  // namespace mbgate::app
