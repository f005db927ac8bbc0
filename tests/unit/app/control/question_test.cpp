// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include <boost/asio/io_context.hpp>
#include <memory>

#include "app/control/control_server.hpp"
#include "unit/io/run_until.hpp"

namespace mbgate::app {
namespace {

TEST(Question, IsAwaitedNoLongerThanItsTime) {
  const auto home = std::make_shared<boost::asio::io_context>();
  std::function<bool()> is_awaited;
  bool is_over = false;
  const auto ask = [&]() -> boost::asio::awaitable<void> {
    Question<bool> question(home);
    is_awaited = question.is_awaited();
    EXPECT_TRUE(is_awaited());
    EXPECT_FALSE(co_await question.wait(std::chrono::seconds(0)));
    is_over = true;
  };
  io::supervise(*home, ask(), "question");
  ASSERT_TRUE(io::run_until(*home, [&] { return is_over; }));
  EXPECT_FALSE(is_awaited());
}

}  // namespace
}  // namespace mbgate::app
