// SPDX-License-Identifier: Apache-2.0
// A first-in, first-out queue of actions. It keeps the memory that it has allocated: a machine
// whose actions are polled after every input allocates nothing more in the long run.
#pragma once

#include <cstddef>
#include <optional>
#include <utility>
#include <vector>

namespace mbgate::bus {

template <typename Action>
class ActionQueue {
 public:
  template <typename Kind>
  void push(Kind&& action) {
    waiting_.emplace_back(std::forward<Kind>(action));
  }

  [[nodiscard]] bool empty() const { return next_ == waiting_.size(); }

  /// Removes and returns the oldest action; nothing if the queue is empty.
  std::optional<Action> poll() {
    if (empty()) {
      return std::nullopt;
    }
    // An action is large: it is moved once, and no room for one is filled with zeros first.
    std::optional<Action> action(std::in_place, std::move(waiting_[next_]));
    if (++next_ == waiting_.size()) {
      next_ = 0;
      waiting_.clear();
      if (waiting_.capacity() > kKeptRoom) {
        waiting_.shrink_to_fit();
      }
    }
    return action;
  }

 private:
  /// When the queue is empty, memory for more actions than this is released (it was needed for a
  /// burst).
  static constexpr std::size_t kKeptRoom = 1024;

  std::vector<Action> waiting_;
  std::size_t next_ = 0;
};

}  // namespace mbgate::bus
