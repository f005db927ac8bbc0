// SPDX-License-Identifier: Apache-2.0
#include "ctl/serial/serial_port.hpp"

#include <gtest/gtest.h>
#include <sys/file.h>

#include <cerrno>
#include <filesystem>

#include "terminal.hpp"

namespace mbgate::ctl {
namespace {

std::string held_port(const std::string& device) {
  return "a gateway or another program holds " + device +
         ": stop it first (systemctl stop mbgated), or scan through it with --host and --port";
}

TEST(SerialPort, IsOursAloneUntilItIsClosed) {
  const Terminal terminal;
  {
    const auto port = SerialPort::open(terminal.path);
    ASSERT_TRUE(port) << port.error();
    const auto second = SerialPort::open(terminal.path);
    ASSERT_FALSE(second);
    EXPECT_EQ(second.error(), EBUSY);
  }
  EXPECT_TRUE(SerialPort::open(terminal.path));
}

TEST(SerialPort, IsNotTakenFromWhoHasLockedIt) {
  const Terminal terminal;
  const int other = ::open(terminal.path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  ASSERT_EQ(flock(other, LOCK_EX | LOCK_NB), 0);
  const auto port = SerialPort::open(terminal.path);
  ::close(other);
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error(), EBUSY);
}

TEST(SerialPort, TakesAnyRate) {
  const Terminal terminal;
  auto port = SerialPort::open(terminal.path);
  ASSERT_TRUE(port) << port.error();
  for (const std::uint32_t baud : {9600U, 38400U, 250000U}) {
    const LineMode mode{modbus::Baud{baud}, {8, modbus::Parity::odd, 1}};
    EXPECT_EQ(port->set_mode(mode), std::nullopt);
  }
}

std::vector<std::uint8_t> present_settings(const Terminal& terminal) {
  const int port = ::open(terminal.path.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
  auto settings = sys::read_tty_settings(port);
  ::close(port);
  EXPECT_FALSE(settings.empty());
  return settings;
}

TEST(SerialPort, HasItsSettingsOfBeforeWhenItIsClosed) {
  const Terminal terminal;
  const auto before = present_settings(terminal);
  {
    auto opened = SerialPort::open(terminal.path);
    ASSERT_TRUE(opened) << opened.error();
    for (const std::uint32_t baud : {19200U, 250000U}) {
      ASSERT_EQ(opened->set_mode({modbus::Baud{baud}, {8, modbus::Parity::even, 1}}), std::nullopt);
    }
    EXPECT_NE(sys::read_tty_settings(opened->descriptor()), before);
    const SerialPort port = *std::move(opened);
  }
  EXPECT_EQ(present_settings(terminal), before);
}

TEST(SerialPort, LeavesBytesAloneUntilItsModeIsSet) {
  const Terminal terminal;
  ASSERT_EQ(::write(terminal.other_end(), "\n", 1), 1);
  EXPECT_TRUE(SerialPort::open(terminal.path));
  const int port = ::open(terminal.path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  char byte = 0;
  EXPECT_EQ(::read(port, &byte, 1), 1);
  ::close(port);
}

TEST(SerialPort, IsNoOtherDevice) {
  const auto port = SerialPort::open("/dev/null");
  ASSERT_FALSE(port);
  EXPECT_EQ(port.error(), ENOTTY);
}

TEST(PortFailure, SaysWhatHelps) {
  const std::string device = "/dev/ttyUSB0";
  EXPECT_EQ(port_failure(device, EBUSY, {}), held_port(device));
  EXPECT_EQ(port_failure(device, ENOTTY, {}), "/dev/ttyUSB0: this is not a serial port");
  EXPECT_EQ(port_failure(device, EACCES, {}),
            "you may not open /dev/ttyUSB0: your user must be in the group dialout (sudo adduser "
            "NAME dialout, then log in again)");
  EXPECT_EQ(port_failure(device, ENOENT, {}), "there is no serial port /dev/ttyUSB0");
  EXPECT_EQ(port_failure(device, ENOENT, {"/dev/serial/by-id/a", "/dev/serial/by-id/b"}),
            "there is no serial port /dev/ttyUSB0; there is /dev/serial/by-id/a, "
            "/dev/serial/by-id/b");
  EXPECT_EQ(port_failure(device, EIO, {}), "cannot open /dev/ttyUSB0: Input/output error");
}

TEST(SerialNames, LeadToPorts) {
  const auto folder =
      std::filesystem::path(testing::TempDir()) / ("serial-names-" + std::to_string(getpid()));
  std::filesystem::create_directory(folder);
  const Terminal terminal;
  std::filesystem::create_symlink("/dev/null", folder / "a");
  std::filesystem::create_symlink(terminal.path, folder / "b");
  const auto names = paths_in(folder);
  const auto name = (folder / "b").string();
  EXPECT_EQ(names, (std::vector<std::string>{(folder / "a").string(), name}));
  EXPECT_EQ(lasting_name(terminal.path, names), name);
  EXPECT_EQ(lasting_name(name, names), std::nullopt);
  EXPECT_EQ(lasting_name("/dev/zero", names), std::nullopt);
  std::filesystem::remove_all(folder);
  EXPECT_TRUE(paths_in(folder).empty());
}

}  // namespace
}  // namespace mbgate::ctl
