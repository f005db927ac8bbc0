// SPDX-License-Identifier: Apache-2.0
// libmodbus is the client over TCP, another libmodbus is the server on a pty, and mbgated stands
// between: two witnesses that know nothing of this project's own encoder and decoder.
#include <gtest/gtest.h>

#include <atomic>
#include <cerrno>
#include <thread>

#include "integration/process.hpp"
#include "integration/rtu_server.hpp"

namespace mbgate::test {
namespace {

class Libmodbus : public testing::Test {
 protected:
  Libmodbus() {
    const auto bus = [](const std::string& name, const RtuServer& server) {
      return "[[bus]]\nname = \"" + name + "\"\ndevice = \"" + server.path() +
             "\"\nbaud = 115200\nparity = \"none\"\necho = false\nlisten_first = \"0ms\"\n"
             "response_timeout = \"20s\"\n";
    };
    const auto config = folder_.write(
        "mbgate.toml",
        "[[listen]]\nname = \"plant\"\nport = 0\n" + bus("line-a", one_) + bus("line-b", two_) +
            "[[route]]\nunit = 1\nbus = \"line-a\"\n[[route]]\nunit = 2\nbus = \"line-b\"\n"
            "[[route]]\nunit = 3\nbus = \"line-a\"\naddress = 1\n"
            "[[route.registers]]\ntable = \"holding\"\nfrom = 1000\ncount = 100\nto = 100\n");
    gateway_.emplace("mbgated", std::vector<std::string>{"--config", config.string()},
                     Process::Options{folder_.path(), {}});
    port_ = gateway_->port_of("plant");
  }
  Context client(int unit) const {
    Context context(modbus_new_tcp("127.0.0.1", port_));
    modbus_set_slave(context.get(), unit);
    modbus_set_response_timeout(context.get(), 60, 0);
    EXPECT_EQ(modbus_connect(context.get()), 0) << modbus_strerror(errno);
    return context;
  }

  TemporaryFolder folder_;
  RtuServer one_{1};
  RtuServer two_{2};
  std::optional<Process> gateway_;
  std::uint16_t port_ = 0;
};

TEST_F(Libmodbus, ReadsAndWritesEveryTable) {
  const Context context = client(1);
  std::uint16_t registers[125];
  ASSERT_EQ(modbus_read_registers(context.get(), 10, 125, registers), 125)
      << modbus_strerror(errno);
  EXPECT_EQ(registers[0], 1010);
  EXPECT_EQ(registers[124], 1134);
  ASSERT_EQ(modbus_read_input_registers(context.get(), 5, 2, registers), 2);
  EXPECT_EQ(registers[1], 2006);
  std::uint8_t bits[20];
  ASSERT_EQ(modbus_read_input_bits(context.get(), 0, 20, bits), 20);
  EXPECT_EQ(bits[3], 1);
  EXPECT_EQ(bits[4], 0);
  const std::uint8_t on[3] = {1, 0, 1};
  ASSERT_EQ(modbus_write_bits(context.get(), 7, 3, on), 3);
  ASSERT_EQ(modbus_write_bit(context.get(), 10, 1), 1);
  ASSERT_EQ(modbus_read_bits(context.get(), 7, 4, bits), 4);
  EXPECT_EQ((std::vector<int>{bits[0], bits[1], bits[2], bits[3]}), (std::vector<int>{1, 0, 1, 1}));
}

TEST_F(Libmodbus, WritesRegistersInEveryWay) {
  const Context context = client(1);
  std::uint16_t back[4];
  ASSERT_EQ(modbus_write_register(context.get(), 20, 0x1234), 1) << modbus_strerror(errno);
  const std::uint16_t three[3] = {7, 8, 9};
  ASSERT_EQ(modbus_write_registers(context.get(), 21, 3, three), 3);
  ASSERT_EQ(modbus_read_registers(context.get(), 20, 4, back), 4);
  EXPECT_EQ((std::vector<int>{back[0], back[1], back[2], back[3]}),
            (std::vector<int>{0x1234, 7, 8, 9}));
  ASSERT_EQ(modbus_mask_write_register(context.get(), 20, 0xFF00, 0x0056), 1);
  ASSERT_EQ(modbus_write_and_read_registers(context.get(), 21, 1, three + 2, 20, 2, back), 2);
  EXPECT_EQ(back[0], 0x1256);
  EXPECT_EQ(back[1], 9);
}

TEST_F(Libmodbus, RewritesAddressesThroughAWindow) {
  const Context context = client(3);
  std::uint16_t registers[2];
  ASSERT_EQ(modbus_read_registers(context.get(), 1000, 2, registers), 2) << modbus_strerror(errno);
  EXPECT_EQ(registers[0], 1100);
  ASSERT_EQ(modbus_write_register(context.get(), 1001, 4711), 1) << modbus_strerror(errno);
  EXPECT_EQ(modbus_read_registers(context.get(), 999, 2, registers), -1);
  EXPECT_EQ(errno, EMBXILADD);
}

TEST_F(Libmodbus, GetsTheDevicesExceptionsAndTheGateways) {
  const Context context = client(1);
  std::uint16_t registers[2];
  EXPECT_EQ(modbus_read_registers(context.get(), RtuServer::kRegisters, 1, registers), -1);
  EXPECT_EQ(errno, EMBXILADD);
  const Context nowhere = client(9);
  EXPECT_EQ(modbus_read_registers(nowhere.get(), 0, 1, registers), -1);
  EXPECT_EQ(errno, EMBXGPATH);
}

TEST_F(Libmodbus, ServesEightClientsAtOnce) {
  std::vector<std::thread> threads;
  threads.reserve(8);
  std::atomic<int> wrong{0};
  for (int number = 0; number < 8; ++number) {
    threads.emplace_back([this, number, &wrong] {
      const int unit = 1 + number % 2;
      const Context context = client(unit);
      std::uint16_t registers[10];
      for (int round = 0; round < 200; ++round) {
        const int address = 30 + (round * 7 + number * 13) % 200;
        const int count = 1 + (round + number) % 10;
        const bool right =
            modbus_read_registers(context.get(), address, count, registers) == count &&
            registers[0] == unit * 1000 + address &&
            registers[count - 1] == unit * 1000 + address + count - 1;
        wrong += right ? 0 : 1;
      }
    });
  }
  for (auto& thread : threads) {
    thread.join();
  }
  EXPECT_EQ(wrong, 0);
}

}  // namespace
}  // namespace mbgate::test
