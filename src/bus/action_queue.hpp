// SPDX-License-Identifier: Apache-2.0
// Actions in the order in which they are wanted. It keeps its room, so that a machine whose actions
// are polled after every input asks for no memory in the long run.
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

  /// The oldest one; nothing if none is left.
  std::optional<Action> poll() {
    if (empty()) {
      return std::nullopt;
    }
    std::optional<Action> action(std::move(waiting_[next_]));
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
  /// What a burst took beyond so many actions is given back.
  static constexpr std::size_t kKeptRoom = 1024;

  std::vector<Action> waiting_;
  std::size_t next_ = 0;
};

}  // namespace mbgate::bus
