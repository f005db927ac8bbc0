// SPDX-License-Identifier: Apache-2.0
// A Gateway in virtual time, for every test and tool that has one: inputs go in, its actions are
// taken until there are none, and time goes on from wake to wake. Who has it decides what the
// actions do.
#pragma once

#include <algorithm>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "gateway/gateway.hpp"
#include "support/action_text.hpp"

namespace mbgate::test {

/// A taker of actions is called with each gateway::Action, or has a `take()` for each kind of them.
/// What returns a bool says false to be given no more. A taker may hand in further inputs.
class GatewayHarness {
 public:
  using Instant = gateway::Instant;

  GatewayHarness(gateway::Settings settings, Instant now)
      : now_(now), gateway_(std::move(settings), now) {}

  /// That of the last input, unless time has gone on since.
  [[nodiscard]] Instant now() const { return now_; }
  [[nodiscard]] gateway::Gateway& gateway() { return gateway_; }
  [[nodiscard]] const gateway::Settings& settings() const { return gateway_.settings(); }
  [[nodiscard]] std::optional<gateway::Wake> next_wake() const { return gateway_.next_wake(); }

  /// Hands an input in; its actions are left for drain().
  void handle(const gateway::Input& input) { gateway_.handle(input, now_); }
  void handle(const gateway::Input& input, Instant at) {
    go_on(at);
    handle(input);
  }

  /// Takes actions until there are none, true, or until the taker wants no more.
  template <typename Taker>
  bool drain(Taker&& taker) {
    while (const auto action = gateway_.poll_action()) {
      if (!give(taker, *action)) {
        return false;
      }
    }
    return true;
  }

  /// Time goes on, and the gateway is not told.
  void go_on(Instant to) { now_ = to; }

  /// Time goes on to the gateway's wake, if there is one to come, and it is woken.
  void wake() {
    if (const auto next = next_wake()) {
      now_ = std::max(now_, next->at);
    }
    handle(gateway::DeadlineReached{});
  }

  /// Wakes the gateway at each of its wakes until then; `after_each` takes the actions.
  template <typename AfterEach>
  void advance(Instant to, AfterEach&& after_each) {
    for (auto next = next_wake(); next && next->at <= to; next = next_wake()) {
      wake();
      after_each();
    }
    go_on(to);
  }

 private:
  template <typename Taker>
  static decltype(auto) call(Taker& taker, const gateway::Action& action) {
    if constexpr (std::is_invocable_v<Taker&, const gateway::Action&>) {
      return taker(action);
    } else {
      return std::visit([&](const auto& what) { return taker.take(what); }, action);
    }
  }
  template <typename Taker>
  static bool give(Taker& taker, const gateway::Action& action) {
    if constexpr (std::is_void_v<decltype(call(taker, action))>) {
      call(taker, action);
      return true;
    } else {
      return call(taker, action);
    }
  }

  Instant now_;
  gateway::Gateway gateway_;
};

}  // namespace mbgate::test
