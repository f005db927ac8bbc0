// SPDX-License-Identifier: Apache-2.0
#include "io/lines/tty_mode.hpp"

#include <gtest/gtest.h>

#include "pseudo_terminal.hpp"

namespace mbgate::io {
namespace {

using modbus::Baud;
using modbus::Parity;

bus::LineSettings line_at(const std::string& path, Baud baud, modbus::CharacterFormat format) {
  bus::LineSettings line;
  line.device = path;
  line.baud = baud;
  line.format = format;
  return line;
}

UniqueFd open_raw(const std::string& path) {
  return UniqueFd(::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC));
}

TEST(BaudTolerance, IsTwoPercentOfTheRateAskedFor) {
  EXPECT_TRUE(is_close_enough(Baud{100000}, Baud{100000}));
  EXPECT_TRUE(is_close_enough(Baud{100000}, Baud{102000}));
  EXPECT_TRUE(is_close_enough(Baud{100000}, Baud{98000}));
  EXPECT_FALSE(is_close_enough(Baud{100000}, Baud{102001}));
  EXPECT_FALSE(is_close_enough(Baud{100000}, Baud{97999}));
  EXPECT_FALSE(is_close_enough(Baud{4000000}, Baud{9600}));
}

TEST(TtyMode, TakesAnyRate) {
  const PseudoTerminal terminal;
  ASSERT_FALSE(terminal.path().empty());
  const UniqueFd fd = open_raw(terminal.path());
  for (const unsigned rate : {300U, 9600U, 19200U, 31250U, 115200U, 250000U, 921600U, 3000000U}) {
    const auto warnings =
        set_tty_mode(fd.get(), line_at(terminal.path(), Baud{rate}, {8, Parity::none, 1}), true);
    ASSERT_TRUE(warnings.has_value()) << rate << ": " << warnings.error();
    EXPECT_TRUE(warnings->empty()) << rate;
  }
}

TEST(TtyMode, WarnsOfLostParityOnAPseudoTerminal) {
  const PseudoTerminal terminal;
  const UniqueFd fd = open_raw(terminal.path());
  const auto warnings =
      set_tty_mode(fd.get(), line_at(terminal.path(), Baud{19200}, {8, Parity::even, 1}), true);
  ASSERT_TRUE(warnings.has_value());
  EXPECT_EQ(*warnings,
            std::vector<std::string>{terminal.path() + ": asked for 8E1, the driver took 8N1"});
}

TEST(TtyMode, RefusesLostParityOnARealPort) {
  const PseudoTerminal terminal;
  const UniqueFd fd = open_raw(terminal.path());
  const auto warnings =
      set_tty_mode(fd.get(), line_at(terminal.path(), Baud{19200}, {8, Parity::even, 2}), false);
  ASSERT_FALSE(warnings.has_value());
  EXPECT_EQ(warnings.error(), terminal.path() + ": asked for 8E2, the driver took 8N2");
}

TEST(TtyMode, NamesWhatWasAskedWhenTheSystemRefuses) {
  const UniqueFd fd(::open("/dev/null", O_RDWR | O_CLOEXEC));
  const auto warnings =
      set_tty_mode(fd.get(), line_at("/dev/null", Baud{9600}, {7, Parity::odd, 1}), false);
  ASSERT_FALSE(warnings.has_value());
  EXPECT_EQ(warnings.error(),
            "/dev/null: cannot read the settings before setting 9600 7O1: Inappropriate ioctl for "
            "device");
}

}  // namespace
}  // namespace mbgate::io
