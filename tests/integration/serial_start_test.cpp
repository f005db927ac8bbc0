// SPDX-License-Identifier: Apache-2.0
// mbgated --serial: a transparent gateway without a configuration file.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cerrno>
#include <chrono>
#include <csignal>

#include "integration/process.hpp"
#include "integration/rtu_server.hpp"

namespace mbgate::test {
namespace {

constexpr int kUserRegister = 0x3C;  // MOONS' user registers: 44 of any value

/// A line with a drive at address 5 that answers at 115200 baud and 1 stop bit only.
constexpr auto kSimulated =
    "[[bus]]\nname = \"a\"\nlink = \"a\"\nbaud = 115200\nparity = \"none\"\npaced = false\n"
    "[[device]]\nname = \"drive\"\nbus = \"a\"\naddress = 5\nmodel = \"moons\"\n";

std::vector<std::string> serial_arguments(const std::vector<std::string>& others) {
  std::vector<std::string> arguments{"--serial", "./a", "--baud", "115200", "--parity", "none"};
  arguments.insert(arguments.end(), others.begin(), others.end());
  return arguments;
}

/// Asks until there is an answer: a busy machine may not answer within the timeout of the bus,
/// which is the default here.
template <typename Ask>
int answer_of(const Ask& ask) {
  const auto end = std::chrono::steady_clock::now() + kPatience;
  int result = ask();
  while (result < 0 && std::chrono::steady_clock::now() < end) {
    result = ask();
  }
  return result;
}

TEST(SerialStart, ServesALineWithoutAFile) {
  TemporaryFolder folder;
  Process simulator("mbgate-sim", {folder.write("sim.toml", kSimulated).string()},
                    {folder.path(), {}});
  simulator.wait_for_line("ready");
  Process gateway("mbgated", serial_arguments({"--listen", "127.0.0.1:0"}), {folder.path(), {}});
  const Context client(modbus_new_tcp("127.0.0.1", gateway.port_of("clients")));
  modbus_set_slave(client.get(), 5);
  modbus_set_response_timeout(client.get(), 60, 0);
  ASSERT_EQ(modbus_connect(client.get()), 0) << modbus_strerror(errno);
  std::uint16_t registers[2] = {};
  const auto read = [&] {
    return modbus_read_registers(client.get(), kUserRegister, 2, registers);
  };
  ASSERT_EQ(answer_of(read), 2) << modbus_strerror(errno);  // only then is a lone echo a drive's
  const auto write = [&] { return modbus_write_register(client.get(), kUserRegister, 4711); };
  ASSERT_EQ(answer_of(write), 1) << modbus_strerror(errno);

  // There is no file to read again, and connections stay.
  gateway.signal(SIGHUP);
  gateway.wait_for_line("reload: nothing has changed");
  ASSERT_EQ(answer_of(read), 2) << modbus_strerror(errno);
  EXPECT_EQ(registers[0], 4711);
  EXPECT_EQ(registers[1], 0);
  gateway.signal(SIGTERM);
  EXPECT_EQ(gateway.wait_for_exit(), 0) << gateway.output();
}

TEST(SerialStart, IsRefusedForEveryoneOnTheNetwork) {
  TemporaryFolder folder;
  Process gateway("mbgated", serial_arguments({"--listen", "0.0.0.0:0"}), {folder.path(), {}});
  EXPECT_EQ(gateway.wait_for_exit(), 64);
  EXPECT_EQ(gateway.output(),
            "--listen: other machines can reach 0.0.0.0: add --allow with the permitted clients, "
            "such as --allow 192.168.10.0/24\nRun with --help for more information.\n");
}

TEST(SerialStart, IsCheckedAsAFileIs) {
  TemporaryFolder folder;
  Process good("mbgated", serial_arguments({"--check"}), {folder.path(), {}});
  EXPECT_EQ(good.wait_for_exit(), 0);
  EXPECT_THAT(good.output(), testing::MatchesRegex(
                                 "configuration ok: 1 listener, 1 bus, 0 devices, 0 routes\n"
                                 "bus [^\n]*: writes have [^\n]*\n"
                                 "sha256 [0-9a-f]+: these options, --print-config . sha256sum\n"));
  for (const char* what : {"--check", "--print-config"}) {
    Process bad("mbgated", serial_arguments({"--stop-bits", "3", what}), {folder.path(), {}});
    EXPECT_EQ(bad.wait_for_exit(), 64);
    EXPECT_EQ(bad.output(),
              "--serial:14:13: error: stop_bits: expected an integer from 1 to 2, found 3\n"
              "stop_bits = 3\n"
              "            ^\n");
  }
}

TEST(SerialStart, PrintsAConfigurationToGoOnWith) {
  TemporaryFolder folder;
  Process printer("mbgated", serial_arguments({"--listen", "[::1]:1502", "--print-config"}),
                  {folder.path(), {}});
  EXPECT_EQ(printer.wait_for_exit(), 0);
  EXPECT_THAT(printer.output(), testing::HasSubstr("\naddress = \"::1\"\nport = 1502\n"));
  const auto config = folder.write("mbgate.toml", printer.output());
  Process check("mbgated", {"--check", "--config", config.string()}, {folder.path(), {}});
  EXPECT_EQ(check.wait_for_exit(), 0) << check.output();
}

}  // namespace
}  // namespace mbgate::test
