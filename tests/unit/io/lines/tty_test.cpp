// SPDX-License-Identifier: Apache-2.0
#include "io/lines/tty.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "unit/sys/pseudo_terminal.hpp"

namespace mbgate::io {
namespace {

bus::LineSettings line_at(const std::string& path) {
  bus::LineSettings line;
  line.device = path;
  line.format = {8, modbus::Parity::none, 1};
  return line;
}

TEST(Tty, OpensAPseudoTerminalLikeAPort) {
  const sys::PseudoTerminal terminal;
  const auto tty = open_tty(line_at(terminal.path()));
  ASSERT_TRUE(tty.has_value()) << tty.error();
  EXPECT_TRUE(tty->warnings.empty());
  int exclusive = 0;
  EXPECT_EQ(::ioctl(tty->fd.get(), TIOCGEXCL, &exclusive), 0);
  EXPECT_NE(exclusive, 0);
}

TEST(Tty, IsRefusedWhileAnotherProgramUsesIt) {
  const sys::PseudoTerminal terminal;
  const auto first = open_tty(line_at(terminal.path()));
  ASSERT_TRUE(first.has_value()) << first.error();
  const auto second = open_tty(line_at(terminal.path()));
  ASSERT_FALSE(second.has_value());
  EXPECT_EQ(second.error(), terminal.path() + ": another program uses it");
}

TEST(Tty, CanBeOpenedAgainOnceGivenBack) {
  const sys::PseudoTerminal terminal;
  for (int i = 0; i < 3; ++i) {
    auto tty = open_tty(line_at(terminal.path()));
    ASSERT_TRUE(tty.has_value()) << tty.error();
    close_tty(std::move(tty->fd), line_at(terminal.path()));
  }
  const sys::UniqueFd stranger(::open(terminal.path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  int exclusive = 1;
  EXPECT_EQ(::ioctl(stranger.get(), TIOCGEXCL, &exclusive), 0);
  EXPECT_EQ(exclusive, 0);
}

TEST(Tty, ForgetsWhatWasReceivedBeforeItWasOpened) {
  const sys::PseudoTerminal terminal;
  // The line exists as long as somebody holds it, and keeps what was sent to it.
  const sys::UniqueFd holder(
      ::open(terminal.path().c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
  const std::array<std::uint8_t, 3> old{'o', 'l', 'd'};
  ASSERT_TRUE(terminal.write(old));
  const auto tty = open_tty(line_at(terminal.path()));
  ASSERT_TRUE(tty.has_value()) << tty.error();
  std::array<char, 8> buffer{};
  EXPECT_EQ(::read(tty->fd.get(), buffer.data(), buffer.size()), -1);
  EXPECT_EQ(errno, EAGAIN);
}

TEST(Tty, SaysThatThePathDoesNotExist) {
  const auto tty = open_tty(line_at("/dev/serial/by-id/absent"));
  ASSERT_FALSE(tty.has_value());
  EXPECT_EQ(tty.error(), "cannot open /dev/serial/by-id/absent: No such file or directory");
}

TEST(Tty, SaysThatThePathIsNoSerialLine) {
  const auto tty = open_tty(line_at("/dev/null"));
  ASSERT_FALSE(tty.has_value());
  EXPECT_EQ(tty.error(), "/dev/null: this is not a serial line");
}

TEST(Tty, SaysWhatIsMissingWhenAccessIsDenied) {
  const auto path =
      std::filesystem::temp_directory_path() / ("mbgate-denied-" + std::to_string(::getpid()));
  std::ofstream(path).put('x');
  std::filesystem::permissions(path, std::filesystem::perms::none);
  const uid_t before = ::geteuid();
  if (before == 0) {
    ASSERT_EQ(::seteuid(65534), 0);
  }
  const auto tty = open_tty(line_at(path.string()));
  if (before == 0) {
    ASSERT_EQ(::seteuid(0), 0);
  }
  std::filesystem::remove(path);
  ASSERT_FALSE(tty.has_value());
  EXPECT_EQ(tty.error(), "cannot open " + path.string() +
                             ": Permission denied; the user that mbgated runs as must be in the "
                             "group of this port, mostly dialout (\"ls -lL " +
                             path.string() +
                             "\" names it), and its mode must let that group read and write");
}

// systemd's device control, unlike the modes of a file, refuses with EPERM.
TEST(Tty, NamesTheDropInWhenTheUnitDoesNotAllowTheDriver) {
  const std::string name =
      "cannot open /dev/ttyLP3: Operation not permitted; if systemd started mbgated, its unit does "
      "not allow this driver, or the driver was loaded after the unit had started: the unit needs "
      "\"DeviceAllow=char-ttyLP rw\" (systemctl edit mbgated)";
  EXPECT_EQ(open_failure("/dev/ttyLP3", EPERM), name);
}

TEST(Tty, NamesTheDriverThatALinkLeadsTo) {
  const auto folder =
      std::filesystem::temp_directory_path() / ("mbgate-links-" + std::to_string(::getpid()));
  std::filesystem::create_directory(folder);
  std::ofstream(folder / "ttyXRUSB12").put('x');
  std::filesystem::create_symlink("ttyXRUSB12", folder / "usb-Exar_Corp-if00-port0");
  const auto text = open_failure((folder / "usb-Exar_Corp-if00-port0").string(), EPERM);
  std::filesystem::remove_all(folder);
  EXPECT_THAT(text, testing::HasSubstr("\"DeviceAllow=char-ttyXRUSB rw\""));
}

TEST(Tty, RefusesKernelDirectionControlWhereTheDriverHasNone) {
  const sys::PseudoTerminal terminal;
  auto line = line_at(terminal.path());
  line.rs485 = bus::Rs485::kernel;
  const auto tty = open_tty(line);
  ASSERT_FALSE(tty.has_value());
  EXPECT_EQ(tty.error(),
            terminal.path() +
                ": the driver has no RS-485 mode; use rs485 = \"off\" if the adapter switches "
                "direction by itself, as most USB adapters do, or rs485 = \"rts\"");
  // The refused line is free again.
  EXPECT_TRUE(open_tty(line_at(terminal.path())).has_value());
}

TEST(Tty, RefusesRtsDirectionControlWithoutRts) {
  const sys::PseudoTerminal terminal;
  auto line = line_at(terminal.path());
  line.rs485 = bus::Rs485::rts;
  const auto tty = open_tty(line);
  ASSERT_FALSE(tty.has_value());
  EXPECT_EQ(tty.error(), terminal.path() +
                             ": rs485 = \"rts\" needs an RTS line: Inappropriate ioctl for device");
}

bus::LineSettings line_at(const std::string& path, modbus::Baud baud,
                          modbus::CharacterFormat format) {
  bus::LineSettings line = line_at(path);
  line.baud = baud;
  line.format = format;
  return line;
}

sys::UniqueFd open_raw(const std::string& path) {
  return sys::UniqueFd(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
}

TEST(TtyMode, WarnsOfLostParityOnAPseudoTerminal) {
  const sys::PseudoTerminal terminal;
  const sys::UniqueFd fd = open_raw(terminal.path());
  const auto warnings = set_mode(
      fd.get(), line_at(terminal.path(), modbus::Baud{19200}, {8, modbus::Parity::even, 1}), true);
  ASSERT_TRUE(warnings.has_value());
  EXPECT_EQ(*warnings,
            std::vector<std::string>{terminal.path() + ": asked for 8E1, the driver took 8N1"});
}

TEST(TtyMode, RefusesLostParityOnARealPort) {
  const sys::PseudoTerminal terminal;
  const sys::UniqueFd fd = open_raw(terminal.path());
  const auto warnings = set_mode(
      fd.get(), line_at(terminal.path(), modbus::Baud{19200}, {8, modbus::Parity::even, 2}), false);
  ASSERT_FALSE(warnings.has_value());
  EXPECT_EQ(warnings.error(), terminal.path() + ": asked for 8E2, the driver took 8N2");
}

TEST(TtyMode, NamesWhatWasAskedWhenTheSystemRefuses) {
  const sys::UniqueFd fd(::open("/dev/null", O_RDWR | O_CLOEXEC));
  const auto warnings = set_mode(
      fd.get(), line_at("/dev/null", modbus::Baud{9600}, {7, modbus::Parity::odd, 1}), false);
  ASSERT_FALSE(warnings.has_value());
  EXPECT_EQ(warnings.error(), "/dev/null: cannot set 9600 7O1: Inappropriate ioctl for device");
}

}  // namespace
}  // namespace mbgate::io
