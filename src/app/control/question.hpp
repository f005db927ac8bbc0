// SPDX-License-Identifier: Apache-2.0
// A question from one thread to another. The coroutine that asks waits for the answer, up to a
// limit.
#pragma once

#include <boost/asio/awaitable.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <utility>

#include "io/supervise.hpp"

namespace mbgate::app {

/// `home` is the context of the thread that asks.
template <typename Value>
class Question {
 public:
  explicit Question(const std::shared_ptr<boost::asio::io_context>& home)
      : home_(home), state_(std::make_shared<State>(*home)) {}

  /// What gives the answer, from the other thread, once. Safe when nobody waits any more.
  [[nodiscard]] std::function<void(Value)> taker() const {
    return [home = std::weak_ptr(home_), state = std::weak_ptr(state_)](Value value) {
      if (const auto running = home.lock()) {
        boost::asio::post(*running, [state, value = std::move(value)]() mutable {
          if (const auto waiting = state.lock()) {
            waiting->value = std::move(value);
            waiting->timer.cancel();
          }
        });
      }
    };
  }

  boost::asio::awaitable<std::optional<Value>> wait(std::chrono::seconds limit) {
    state_->timer.expires_after(limit);
    co_await state_->timer.async_wait(io::kAsTuple);
    co_return std::move(state_->value);
  }

 private:
  struct State {
    explicit State(boost::asio::io_context& context) : timer(context) {}
    boost::asio::steady_timer timer;
    std::optional<Value> value;
  };

  std::weak_ptr<boost::asio::io_context> home_;
  std::shared_ptr<State> state_;
};

}  // namespace mbgate::app
