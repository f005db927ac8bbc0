// SPDX-License-Identifier: Apache-2.0
#include "io/blocking_calls.hpp"

#include <gtest/gtest.h>

#include <future>

#include "run_until.hpp"

namespace mbgate::io {
namespace {

TEST(BlockingCalls, ReturnTheirResultOnTheIoThread) {
  boost::asio::io_context context;
  BlockingCalls calls(context);
  std::thread::id called_on;
  std::thread::id returned_on;
  ASSERT_TRUE(calls.run([] { return std::this_thread::get_id(); },
                        [&](std::thread::id id) {
                          called_on = id;
                          returned_on = std::this_thread::get_id();
                        }));
  ASSERT_TRUE(run_until(context, [&] { return returned_on != std::thread::id(); }));
  EXPECT_EQ(returned_on, std::this_thread::get_id());
  EXPECT_NE(called_on, returned_on);
}

TEST(BlockingCalls, DoNotWaitForEachOther) {
  boost::asio::io_context context;
  BlockingCalls calls(context);
  std::promise<int> release;
  bool first_done = false;
  bool second_done = false;
  ASSERT_TRUE(calls.run([blocked = release.get_future()]() mutable { return blocked.get(); },
                        [&](int) { first_done = true; }));
  ASSERT_TRUE(calls.run([] { return 2; }, [&](int) { second_done = true; }));
  ASSERT_TRUE(run_until(context, [&] { return second_done; }));
  EXPECT_FALSE(first_done);
  release.set_value(1);
  EXPECT_TRUE(run_until(context, [&] { return first_done; }));
}

TEST(BlockingCalls, DropTheResultOfACallThatOutlivesThem) {
  auto context = std::make_unique<boost::asio::io_context>();
  std::promise<void> release;
  // Destroyed with the result, on the thread of the call.
  auto dropped = std::make_shared<std::promise<void>>();
  auto was_dropped = dropped->get_future();
  struct Result {
    std::shared_ptr<std::promise<void>> promise;
    Result(std::shared_ptr<std::promise<void>> p) : promise(std::move(p)) {}
    Result(Result&&) = default;
    Result& operator=(Result&&) = default;
    ~Result() {
      if (promise) {
        promise->set_value();
      }
    }
  };
  {
    BlockingCalls calls(*context);
    ASSERT_TRUE(calls.run(
        [blocked = release.get_future(), dropped = std::move(dropped)]() mutable {
          blocked.wait();
          return Result(std::move(dropped));
        },
        [](Result) { ADD_FAILURE() << "the result of a forgotten call arrived"; }));
  }
  context.reset();
  release.set_value();
  EXPECT_EQ(was_dropped.wait_for(std::chrono::seconds(60)), std::future_status::ready);
}

}  // namespace
}  // namespace mbgate::io
