// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <optional>

#include "app/systemd.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::app {
namespace {

constexpr std::chrono::milliseconds kFedWithin{20};

class WatchdogTest : public testing::Test {
 protected:
  boost::asio::io_context context_;
  bool is_well_ = true;
  int asked_ = 0;
  int fed_ = 0;
  Watchdog watchdog_{context_,
                     [this] {
                       ++asked_;
                       return is_well_;
                     },
                     [this] { ++fed_; }};
};

TEST_F(WatchdogTest, IsFedAtOnceAndAgainAndAgain) {
  watchdog_.start(kFedWithin);
  EXPECT_EQ(fed_, 1);
  EXPECT_TRUE(io::run_until(context_, [this] { return fed_ == 5; }));
  EXPECT_EQ(asked_, 5);
}

TEST_F(WatchdogTest, IsNotFedWhileDeadlinesAreMissed) {
  is_well_ = false;
  watchdog_.start(kFedWithin);
  ASSERT_TRUE(io::run_until(context_, [this] { return asked_ == 20; }));
  EXPECT_EQ(fed_, 0);
  is_well_ = true;
  ASSERT_TRUE(io::run_until(context_, [this] { return asked_ == 22; }));
  EXPECT_EQ(fed_, 2);
}

// A timer of the same io_context that is set later and rings later tells, however busy the machine.
TEST_F(WatchdogTest, LooksAgainBeforeHalfOfTheLimitIsOver) {
  constexpr std::chrono::milliseconds kLonger{400};
  is_well_ = false;
  watchdog_.start(kLonger);
  is_well_ = true;
  boost::asio::steady_timer later(context_, kLonger / 4);
  std::optional<int> fed_before;
  later.async_wait([&](const boost::system::error_code&) { fed_before = fed_; });
  ASSERT_TRUE(io::run_until(context_, [&] { return fed_before.has_value(); }));
  EXPECT_EQ(fed_before, 1);
  EXPECT_EQ(asked_, 2);
}

}  // namespace
}  // namespace mbgate::app
