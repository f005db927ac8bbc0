// SPDX-License-Identifier: Apache-2.0
#include "sys/tty.hpp"

#include <gtest/gtest.h>
#include <sys/file.h>

#include <cerrno>

#include "unit/sys/pseudo_terminal.hpp"

namespace mbgate::sys {
namespace {

TEST(TtyMode, HasARateTwoPercentOffAtMost) {
  const auto is_near = [](std::uint32_t asked, std::uint32_t got) {
    return TtyMode{got}.has_rate_near(asked);
  };
  EXPECT_TRUE(is_near(100000, 100000));
  EXPECT_TRUE(is_near(100000, 102000));
  EXPECT_TRUE(is_near(100000, 98000));
  EXPECT_FALSE(is_near(100000, 102001));
  EXPECT_FALSE(is_near(100000, 97999));
  EXPECT_FALSE(is_near(4000000, 9600));
}

TEST(TtyMode, NamesItsFormat) {
  EXPECT_EQ(TtyMode{}.format_text(), "8N1");
  EXPECT_EQ((TtyMode{9600, 7, TtyParity::odd, 2}.format_text()), "7O2");
}

TEST(Tty, TakesAnyRate) {
  const PseudoTerminal terminal;
  const UniqueFd fd = open_tty(terminal.path());
  ASSERT_TRUE(fd.is_open());
  for (const unsigned rate : {300U, 9600U, 19200U, 31250U, 115200U, 250000U, 921600U, 3000000U}) {
    const auto real = set_tty_mode(fd.get(), {rate});
    ASSERT_TRUE(real) << rate;
    EXPECT_EQ(real->baud, rate);
  }
}

TEST(Tty, IsForOneAlone) {
  const PseudoTerminal terminal;
  {
    const UniqueFd fd = open_tty(terminal.path());
    ASSERT_TRUE(fd.is_open());
    EXPECT_FALSE(open_tty(terminal.path()).is_open());
    EXPECT_EQ(errno, EBUSY);
    release_tty(fd.get());
  }
  const UniqueFd other(::open(terminal.path().c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC));
  ASSERT_EQ(::flock(other.get(), LOCK_EX | LOCK_NB), 0);
  EXPECT_FALSE(open_tty(terminal.path()).is_open());
  EXPECT_EQ(errno, EBUSY);
}

TEST(Tty, IsNoOtherDevice) {
  EXPECT_FALSE(open_tty("/dev/null").is_open());
  EXPECT_EQ(errno, ENOTTY);
}

}  // namespace
}  // namespace mbgate::sys
