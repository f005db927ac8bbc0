// SPDX-License-Identifier: Apache-2.0
// Until when what a device owes holds back requests to it, at the latest and for each function by
// itself: once it has answered, those of a function that it owes nothing of go soon.
#pragma once

#include <algorithm>
#include <map>
#include <optional>

#include "bus/instant.hpp"

namespace mbgate::soak {

using bus::Duration;
using bus::Instant;

class FunctionHolds {
 public:
  /// If it is not answered, its function is held back until then.
  void note_sent(std::uint8_t function, Instant now, Instant until) {
    const auto is_over = [&](const auto& entry) { return entry.second < now; };
    owed_ = 1 + (std::ranges::all_of(held_, is_over) ? 0 : owed_);
    Instant& held = held_[function & kNoException];
    held = std::max(held, until);
    others_from_.reset();
  }
  /// Nothing is owed but what was before.
  void note_paid(Instant until) {
    for (auto& [function, held] : held_) {
      held = std::min(held, until);
    }
    owed_ = 0;
  }
  /// It may have been told to boot.
  void note_boots(Instant until) { boots_until_ = std::max(boots_until_, until); }
  /// It has answered what was sent last, and took no longer than this.
  void note_took(Duration took) { longest_ = std::max(longest_, took); }
  /// The gateway has taken that answer.
  void note_answered(Instant now) {
    owed_ -= owed_ > 0 ? 1U : 0U;
    constexpr int kAnswerTimes = 4;
    constexpr Duration kKept = std::chrono::milliseconds(20);  // by an adapter
    others_from_ = now + std::max<Duration>(kKept, kAnswerTimes * longest_);
  }
  /// `all`: until when any request to it is held back.
  [[nodiscard]] Instant until(std::uint8_t function, Instant all) const {
    if (!others_from_ || owed_ > kMostKnown) {
      return all;
    }
    const auto same = held_.find(function & kNoException);
    const Instant own = same == held_.end() ? Instant::min() : same->second;
    return std::min(all, std::max({own, boots_until_, *others_from_}));
  }

 private:
  static constexpr unsigned kNoException = 0x7F;
  static constexpr unsigned kMostKnown = 8;  // what is owed beyond that holds back everything

  std::map<unsigned, Instant> held_;
  unsigned owed_ = 0;  // answers, at most
  std::optional<Instant> others_from_;
  Instant boots_until_ = Instant::min();
  Duration longest_{0};
};

}  // namespace mbgate::soak
