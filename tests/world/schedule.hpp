// SPDX-License-Identifier: Apache-2.0
// What will happen in the plant, in the order of its instants; what is planned for the same instant
// happens in the order in which it was planned, so that a run repeats exactly.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "bus/instant.hpp"

namespace mbgate::world {

using bus::Duration;
using bus::Instant;

class Schedule {
 public:
  using Happening = std::function<void()>;

  [[nodiscard]] Instant now() const { return now_; }
  void at(Instant instant, Happening happening) {
    entries_.push_back({std::max(instant, now_), order_++, std::move(happening)});
    std::ranges::push_heap(entries_, later);
  }
  void after(Duration delay, Happening happening) { at(now_ + delay, std::move(happening)); }
  [[nodiscard]] std::optional<Instant> next() const {
    return entries_.empty() ? std::nullopt : std::optional(entries_.front().at);
  }
  /// Time goes on; never back.
  void advance(Instant instant) { now_ = std::max(now_, instant); }
  /// Lets the next thing happen if its time has come.
  bool run_one() {
    if (entries_.empty() || entries_.front().at > now_) {
      return false;
    }
    std::ranges::pop_heap(entries_, later);
    const Happening happening = std::move(entries_.back().happening);
    entries_.pop_back();
    happening();
    return true;
  }

 private:
  struct Entry {
    Instant at;
    std::uint64_t order;
    Happening happening;
  };
  static bool later(const Entry& a, const Entry& b) {
    return a.at != b.at ? a.at > b.at : a.order > b.order;
  }

  Instant now_{std::chrono::seconds(1)};
  std::uint64_t order_ = 0;
  std::vector<Entry> entries_;
};

}  // namespace mbgate::world
