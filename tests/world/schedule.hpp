// SPDX-License-Identifier: Apache-2.0
// What will happen in the plant, in the order of its instants; what is planned for the same instant
// happens in the order in which it was planned, so that a run repeats exactly.
#pragma once

#include <algorithm>
#include <cstdint>
#include <functional>
#include <optional>
#include <utility>
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
    auto place = static_cast<std::uint32_t>(happenings_.size());
    if (free_.empty()) {
      happenings_.push_back(std::move(happening));
    } else {
      place = free_.back();
      free_.pop_back();
      happenings_[place] = std::move(happening);
    }
    entries_.push_back({std::max(instant, now_), order_++, place});
    std::ranges::push_heap(entries_, later);
  }
  void after(Duration delay, Happening happening) { at(now_ + delay, std::move(happening)); }
  [[nodiscard]] std::optional<Instant> next() const {
    return entries_.empty() ? std::nullopt : std::optional(entries_.front().at);
  }
  /// Time goes on; never back.
  void advance(Instant instant) { now_ = std::max(now_, instant); }
  /// Lets the next thing happen, whose time has come.
  void run_one() {
    std::ranges::pop_heap(entries_, later);
    const std::uint32_t place = entries_.back().place;
    entries_.pop_back();
    const Happening happening = std::exchange(happenings_[place], nullptr);
    free_.push_back(place);
    happening();
  }

 private:
  struct Entry {
    Instant at;
    std::uint64_t order;
    std::uint32_t place;  ///< in happenings_: entries are small, for the heap moves them
  };
  static bool later(const Entry& a, const Entry& b) {
    return a.at != b.at ? a.at > b.at : a.order > b.order;
  }

  Instant now_{std::chrono::seconds(1)};
  std::uint64_t order_ = 0;
  std::vector<Entry> entries_;
  std::vector<Happening> happenings_;
  std::vector<std::uint32_t> free_;
};

}  // namespace mbgate::world
