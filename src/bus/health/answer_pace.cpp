// SPDX-License-Identifier: Apache-2.0
#include "bus/health/answer_pace.hpp"

#include <cstdint>

namespace mbgate::bus {
namespace {

constexpr auto kRecently = std::chrono::minutes(1);

constexpr auto kForgettingTime = std::chrono::minutes(1);
constexpr int kSuddenPart = 8;       // an eighth sooner
constexpr int kForgottenPart = 8;    // an eighth in each of these
constexpr int kLongestMemory = 100;  // of these; nothing is left by then

}  // namespace

bool AnswerPace::note_answer(Duration took, Duration or_took, Instant now) {
  if (now - while_began_ >= kRecently) {
    const bool is_recent = now - while_began_ < 2 * kRecently;
    longest_before_ = is_recent ? longest_answer_ : Duration{0};
    shortest_before_ = is_recent ? shortest_answer_ : Duration::max();
    longest_answer_ = Duration{0};
    shortest_answer_ = Duration::max();
    while_began_ = now;
  }
  const Duration shortest = std::min(shortest_answer_, shortest_before_);
  const bool is_first = shortest == Duration::max();
  const bool is_sudden = !is_first && took < shortest - shortest / kSuddenPart;
  longest_answer_ = std::max(longest_answer_, is_first || is_sudden ? or_took : took);
  shortest_answer_ = std::min(shortest_answer_, took);
  return is_sudden;
}

void AnswerPace::note_late(Duration covering, Instant now) {
  const Duration known = learned(now);
  if (covering > known - known / kForgottenPart) {  // what is left next would not cover it
    learned_ = std::max(covering, known);
    learned_at_ = now;
  }
}

Duration AnswerPace::learned(Instant now) const {
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

}  // namespace mbgate::bus
