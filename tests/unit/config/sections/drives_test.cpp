// SPDX-License-Identifier: Apache-2.0
// What tests/config/valid/drives.toml becomes: profiles, lines of every mode, windows.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "support/config_text.hpp"

namespace mbgate::config {
namespace {

using namespace std::chrono_literals;
using modbus::Table;
using testing::ElementsAre;

const std::filesystem::path kFolder = std::filesystem::path(MBGATE_SOURCE_DIR) / "tests/config";

class Drives : public testing::Test {
 public:
  void SetUp() override {
    const auto loaded =
        load_settings(kFolder / "valid/drives.toml", {.otherwise = {kFolder / "profiles"}});
    ASSERT_EQ(render(loaded.diagnostics), "");
    ASSERT_TRUE(loaded.settings);
    settings = *loaded.settings;
  }
  gateway::Settings settings;
};

TEST_F(Drives, HaveLinesOfEveryMode) {
  const auto& ascii = settings.buses.at(0).line;
  EXPECT_EQ(ascii.framing, bus::Framing::ascii);
  EXPECT_EQ(ascii.format, (modbus::CharacterFormat{7, modbus::Parity::even, 1}));
  EXPECT_FALSE(ascii.remote);
  const auto& remote = settings.buses.at(1);
  EXPECT_EQ(remote.line.framing, bus::Framing::ascii);
  EXPECT_EQ(remote.line.remote, (bus::Endpoint{"fe80::1", 4001}));
  EXPECT_EQ(remote.line.device, "tcp://[fe80::1]:4001");
  EXPECT_EQ(remote.line.format.data_bits, 8U);
  EXPECT_EQ(remote.line.baud, modbus::Baud{9600});
  EXPECT_EQ(remote.frame_gap, 100us);
  const auto& server = settings.buses.at(2);
  EXPECT_EQ(server.line.framing, bus::Framing::tcp);
  EXPECT_EQ(server.line.remote, (bus::Endpoint{"192.168.10.20", 1502}));
  EXPECT_EQ(server.line.device, "");
  EXPECT_EQ(server.outstanding, 16U);
  EXPECT_TRUE(server.check_unit);
  EXPECT_TRUE(server.check_transaction);
  EXPECT_EQ(server.one_device, false);
  EXPECT_EQ(server.replace_after, 0U);
  EXPECT_EQ(server.line.connection, (bus::ConnectionTimes{1s, 500ms, 2s}));
  EXPECT_EQ(remote.line.connection, (bus::ConnectionTimes{4s, 2s, 60s}));
  const auto& plain = settings.buses.at(3);
  EXPECT_EQ(plain.outstanding, 1U);
  EXPECT_TRUE(plain.check_unit);
  EXPECT_FALSE(plain.check_transaction);
  EXPECT_EQ(plain.one_device, std::nullopt);
  EXPECT_EQ(plain.replace_after, 5U);
  EXPECT_EQ(plain.line.connection, (bus::ConnectionTimes{4s, 2s, 15s}));
  EXPECT_EQ(settings.buses.at(4).line.framing, bus::Framing::rtu);
  EXPECT_EQ(settings.buses.at(4).line.remote, (bus::Endpoint{"servers.plant.example", 4002}));
  EXPECT_EQ(settings.buses.at(4).line.format.data_bits, 8U);
}

TEST_F(Drives, HaveTheirProfilesAndWhatTheirUserStates) {
  const auto& axis = settings.devices.at(0);
  EXPECT_EQ(axis.profile.name, "settable");
  EXPECT_EQ(axis.timing.response_wait, 4ms);
  EXPECT_EQ(axis.word_order, drive::WordOrder::little);
  EXPECT_EQ(axis.opcode_order, drive::WordOrder::big);
  EXPECT_EQ(axis.write_function, 16);
  EXPECT_EQ(settings.devices.at(2).write_function, 6);
  EXPECT_TRUE(settings.devices.at(2).split_values);
  EXPECT_TRUE(axis.split_writes);
  EXPECT_TRUE(axis.verify_word_order);
  EXPECT_TRUE(axis.limits_values);
  EXPECT_TRUE(axis.allow_reconfigure);
  std::vector<std::pair<int, int>> own;
  for (const auto& value : axis.profile.values.all()) {
    if (value.table == Table::holding_registers && value.first >= 100) {
      own.emplace_back(value.first, value.registers);
    }
  }
  EXPECT_THAT(own, ElementsAre(std::pair(120, 2), std::pair(130, 2), std::pair(132, 2),
                               std::pair(140, 4), std::pair(144, 4)));
  EXPECT_NE(axis.profile.values.at(Table::input_registers, 41), nullptr);
}

TEST_F(Drives, TakeDefaultsFromTheirProfiles) {
  const auto& feeder = settings.devices.at(1);
  EXPECT_EQ(feeder.word_order, drive::WordOrder::little);
  EXPECT_EQ(feeder.write_function, std::nullopt);  // the maker prefers 16
  EXPECT_EQ(feeder.timing.response_wait, 1ms);
  EXPECT_FALSE(feeder.limits_values || feeder.split_values || feeder.split_writes ||
               feeder.verify_word_order || feeder.allow_reconfigure);
  const auto& valve = settings.devices.at(2);
  EXPECT_EQ(valve.profile.name, "generic");
  EXPECT_EQ(valve.address, 255);
  EXPECT_FALSE(valve.word_order);
  EXPECT_EQ(settings.devices.at(3).address, 0);
  EXPECT_NE(settings.devices.at(3).profile.values.at(Table::holding_registers, 121), nullptr);
}

TEST_F(Drives, AreReachedThroughWindowsBetweenTables) {
  const auto& route = settings.routes.at(0);
  EXPECT_EQ(route.word_order, drive::WordOrder::big);
  ASSERT_EQ(route.windows.size(), 3U);
  EXPECT_EQ(route.windows[0].to_table, Table::holding_registers);
  EXPECT_EQ(route.windows[1].table, Table::holding_registers);
  EXPECT_EQ(route.windows[1].from, 1100);
  EXPECT_EQ(route.windows[1].to_table, Table::input_registers);
  EXPECT_EQ(route.windows[2].table, Table::discrete_inputs);
  EXPECT_EQ(route.windows[2].to_table, Table::coils);
  EXPECT_EQ(route.functions.allowed, routing::FunctionRules::rewritable().allowed);
}

TEST_F(Drives, AreReachedOverTcpAtEveryUnit) {
  EXPECT_FALSE(settings.routes.at(1).word_order);
  EXPECT_EQ(settings.routes.at(1).first_address, 0);
  EXPECT_EQ(settings.routes.at(2).first_address, 240);
  EXPECT_EQ(settings.routes.at(3).first_address, 0);
  EXPECT_FALSE(settings.routes.at(3).is_broadcast());
}

TEST_F(Drives, HearBroadcastsOnSerialLinesOnly) {
  const auto& broadcast = settings.routes.at(5);
  EXPECT_TRUE(broadcast.is_broadcast());
  EXPECT_THAT(broadcast.buses, ElementsAre(drive::BusId{0}, drive::BusId{1}, drive::BusId{4}));
  EXPECT_EQ(broadcast.word_order, drive::WordOrder::big);
}

std::string server_with(const std::string& keys, const std::string& address) {
  return "[gateway]\nunit = 1\n[[listen]]\nname = \"plant\"\naddress = \"127.0.0.1\"\nport = 0\n"
         "bus = \"cell\"\n"
         "[[bus]]\nname = \"cell\"\nmode = \"tcp\"\nhost = \"192.168.10.20\"\n" +
         keys + "\n[[device]]\nname = \"axis\"\nbus = \"cell\"\n" + address + "\n";
}

TEST(ModbusTcpServers, AreOneDeviceUnderEveryUnitIfItsAddressIsTheDefault) {
  const auto check = [](const std::string& keys, const std::string& address) {
    const auto loaded = test::load_settings_text("x.toml", server_with(keys, address));
    return loaded.settings ? check_summary(*loaded.settings) : render(loaded.diagnostics);
  };
  const auto every = testing::HasSubstr("\nbus cell: every unit is device axis\n");
  const auto alone = testing::HasSubstr("\nbus cell: device axis is unit 5 alone;");
  EXPECT_THAT(check("", ""), every);
  EXPECT_THAT(check("", "address = 255"), every);
  EXPECT_THAT(check("", "address = 5"), alone);
  EXPECT_THAT(check("one_device = true", "address = 5"), every);
  EXPECT_THAT(check("one_device = false", "address = 255"),
              testing::HasSubstr("device axis is unit 255 alone;"));
  const auto two = check("", "[[device]]\nname = \"valve\"\nbus = \"cell\"\naddress = 7");
  EXPECT_THAT(two, testing::Not(testing::HasSubstr("bus cell: every unit")));
}

TEST(Routes, ToAsciiLinesNameWhatSetsAnotherDelimiter) {
  const auto passes = [](const std::string& mode, const std::string& functions) {
    const auto loaded = test::load_settings_text(
        "x.toml",
        "[[listen]]\nname = \"plant\"\naddress = \"127.0.0.1\"\nport = 0\n"
        "[[bus]]\nname = \"line\"\ndevice = \"/dev/ttyS0\"\nmode = \"" +
            mode + "\"\n[[route]]\nunit = 1\nbus = \"line\"\naddress = 1\n" + functions);
    EXPECT_TRUE(loaded.settings) << render(loaded.diagnostics);
    return loaded.settings->routes.at(0).functions.change_delimiter;
  };
  EXPECT_TRUE(passes("rtu", ""));
  EXPECT_TRUE(passes("rtu", "functions = [8]"));
  EXPECT_TRUE(passes("rtu", "functions = [3, \"8/3\"]"));
  EXPECT_FALSE(passes("rtu", "functions = [3]"));
  EXPECT_FALSE(
      passes("rtu", "[[route.registers]]\ntable = \"coils\"\nfrom = 0\ncount = 1\nto = 0"));
  EXPECT_FALSE(passes("ascii", ""));
  EXPECT_FALSE(passes("ascii", "functions = [8]"));
  EXPECT_TRUE(passes("ascii", "functions = [3, \"8/3\"]"));
}

TEST(ResponseTimeouts, AreTheProfilesUnlessTheUserSaysMore) {
  const auto timeout = [](const std::string& of_bus, const std::string& of_device) {
    const auto loaded = test::load_settings_text(
        "x.toml",
        "[[listen]]\nname = \"plant\"\naddress = \"127.0.0.1\"\nport = 0\nbus = \"line\"\n"
        "[[bus]]\nname = \"line\"\ndevice = \"/dev/ttyS0\"\n" +
            of_bus + "\n[[device]]\nname = \"axis\"\nbus = \"line\"\naddress = 1\n" + of_device,
        {.otherwise = {std::filesystem::path(MBGATE_SOURCE_DIR) / "conf/profiles"}});
    EXPECT_TRUE(loaded.settings) << render(loaded.diagnostics);
    return loaded.settings->devices.at(0).timing.response_timeout;
  };
  const std::string stepper = "profile = \"rs485-stepper\"\n";
  EXPECT_EQ(timeout("", ""), 1s);
  EXPECT_EQ(timeout("", stepper), 300ms);
  EXPECT_EQ(timeout("response_timeout = \"2s\"", stepper), 2s);
  EXPECT_EQ(timeout("", stepper + "response_timeout = \"50ms\""), 50ms);
  EXPECT_EQ(timeout("response_timeout = \"2s\"", stepper + "response_timeout = \"50ms\""), 50ms);
}

}  // namespace
}  // namespace mbgate::config
