// SPDX-License-Identifier: Apache-2.0
// How long a device takes to answer, and how late its answers can be: learned from those that come,
// and forgotten again.
#pragma once

#include <algorithm>
#include <cstdint>

#include "bus/instant.hpp"

namespace mbgate::bus {

class AnswerPace {
 public:
  /// An answer came; `took`: from the end of the transmission. If it may also be the answer to an
  /// earlier transmission, `or_took` is the time from the end of that one, and counts unless the
  /// device is known to answer as fast as `took`. `is_ordinary`: not of slow registers. True: it
  /// came clearly sooner than any other answer of the last minute.
  bool note_answer(Duration took, Duration or_took, Instant now, bool is_ordinary = true) {
    if (now - while_began_ >= kRecently) {
      const bool is_recent = now - while_began_ < 2 * kRecently;
      longest_before_ = is_recent ? longest_answer_ : Duration{0};
      ordinary_before_ = is_recent ? longest_ordinary_ : Duration{0};
      shortest_before_ = is_recent ? shortest_answer_ : Duration::max();
      longest_answer_ = longest_ordinary_ = Duration{0};
      shortest_answer_ = Duration::max();
      while_began_ = now;
    }
    const Duration shortest = std::min(shortest_answer_, shortest_before_);
    const bool is_first = shortest == Duration::max();
    const bool is_sudden = !is_first && took < shortest - shortest / kSuddenPart;
    const Duration counted = is_first || is_sudden ? or_took : took;
    longest_answer_ = std::max(longest_answer_, counted);
    longest_ordinary_ = std::max(longest_ordinary_, is_ordinary ? counted : Duration{0});
    shortest_answer_ = std::min(shortest_answer_, took);
    return is_sudden;
  }
  /// A late answer came, which a quarantine as long as this would have covered.
  void note_late(Duration covering, Instant now) {
    const Duration known = learned(now);
    if (covering > known - known / kForgottenPart) {  // what is left next would not cover it
      learned_ = std::max(covering, known);
      learned_at_ = now;
    }
  }

  /// The longest that an answer took in the last minute, and in the one before.
  [[nodiscard]] Duration longest_answer() const {
    return std::max(longest_answer_, longest_before_);
  }
  /// The same without answers of slow registers.
  [[nodiscard]] Duration longest_ordinary() const {
    return std::max(longest_ordinary_, ordinary_before_);
  }
  /// How long a quarantine must be to cover what was seen of late answers. It shrinks by an eighth
  /// in each minute in which none came that the rest would not cover.
  [[nodiscard]] Duration learned(Instant now) const {
    if (learned_ == Duration{0} || now <= learned_at_) {
      return learned_;
    }
    const auto passed = (now - learned_at_) / kForgettingTime;
    Duration left = learned_;
    for (int at = 0; at < std::min<std::int64_t>(passed, kLongestMemory); ++at) {
      left -= left / kForgottenPart;
    }
    return left;
  }

 private:
  static constexpr auto kRecently = std::chrono::minutes(1);
  static constexpr auto kForgettingTime = std::chrono::minutes(1);
  static constexpr int kSuddenPart = 8;       // an eighth sooner
  static constexpr int kForgottenPart = 8;    // an eighth in each of these
  static constexpr int kLongestMemory = 100;  // of these; nothing is left by then

  Duration longest_answer_{0};  // in this period, and in the one before
  Duration longest_before_{0};
  Duration longest_ordinary_{0};
  Duration ordinary_before_{0};
  Duration shortest_answer_ = Duration::max();
  Duration shortest_before_ = Duration::max();
  Instant while_began_;
  Duration learned_{0};
  Instant learned_at_ = Instant::min();
};

}  // namespace mbgate::bus
