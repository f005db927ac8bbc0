// SPDX-License-Identifier: Apache-2.0
#include "io/supervise.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

namespace mbgate::io {
namespace {

boost::asio::awaitable<void> fail() {
  throw std::logic_error("a fault of our own");
  co_return;
}

TEST(Supervise, LetsAnExceptionOutOfTheLoopWithTheNameOfTheCoroutine) {
  boost::asio::io_context context;
  supervise(context, fail(), "line read");
  try {
    context.run();
    FAIL() << "the exception was swallowed";
  } catch (const std::runtime_error& error) {
    EXPECT_STREQ(error.what(), "line read: a fault of our own");
  }
}

}  // namespace
}  // namespace mbgate::io
