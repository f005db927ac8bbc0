// SPDX-License-Identifier: Apache-2.0
#include "bus/device_health.hpp"

#include <algorithm>

namespace mbgate::bus {
namespace {

constexpr auto kForgettingTime = std::chrono::minutes(1);
constexpr int kForgottenPart = 8;    // an eighth in each of these
constexpr int kLongestMemory = 100;  // of these; nothing is left by then
constexpr int kMarginPart = 4;       // a quarter more than what was seen

}  // namespace

bool DeviceHealth::note_unanswered(Instant due, const Timing& timing) {
  owe(due);
  ++unanswered_in_row_;
  if (offline_ || timing.offline_after == 0 || unanswered_in_row_ < timing.offline_after) {
    return false;
  }
  offline_ = true;
  return true;
}

void DeviceHealth::owe(Instant due) {
  if (owed_.size() == owed_.capacity()) {
    owed_.erase(owed_.begin());
    ++more_owed_;
  }
  owed_.push_back(due);
  last_due_ = std::max(last_due_, due);
}

bool DeviceHealth::note_answered(Instant due, Instant now) {
  if (!owed_.empty()) {
    suspected_ = std::max(suspected_, now - owed_.front());
    owed_.erase(owed_.begin());
    owe(due);
  }
  return answer_seen();
}

bool DeviceHealth::answer_seen() {
  unanswered_in_row_ = 0;
  return std::exchange(offline_, false);
}

void DeviceHealth::note_asked() {
  if (!owed_.empty()) {
    given_up_ = owed_.front();
    owed_.clear();
    more_owed_ = 0;
    suspected_ = Duration{0};
  }
}

std::optional<DeviceHealth::Late> DeviceHealth::note_unexpected(Instant now, const Timing& timing) {
  const auto due = owed_.empty() ? given_up_ : std::optional(owed_.front());
  const Duration longest = std::max(timing.quarantine_max, quarantine(now, timing));
  if (!due || now > *due + longest) {
    return std::nullopt;
  }
  Late late{};
  late.lateness = std::max({now - *due, suspected_, Duration{0}});
  if (owed_.empty()) {
    given_up_.reset();
  } else if (more_owed_ > 0) {
    --more_owed_;
  } else {
    owed_.erase(owed_.begin());
  }
  if (owed_.empty()) {
    suspected_ = Duration{0};
  }
  const Duration covering =
      std::min(late.lateness + late.lateness / kMarginPart, timing.quarantine_max);
  late.grew = covering > quarantine(now, timing);
  if (covering > learned(now)) {
    learned_ = covering;
    learned_at_ = now;
  }
  late.back = answer_seen();
  return late;
}

unsigned DeviceHealth::owed(Instant now, const Timing& timing) const {
  return now < held_until(timing) ? static_cast<unsigned>(owed_.size()) + more_owed_ : 0U;
}

Instant DeviceHealth::held_until(const Timing& timing) const {
  return owed_.empty() ? Instant::min() : last_due_ + quarantine(last_due_, timing);
}

Duration DeviceHealth::quarantine(Instant now, const Timing& timing) const {
  return std::max(timing.quarantine_or_default(), std::min(learned(now), timing.quarantine_max));
}

Duration DeviceHealth::learned(Instant now) const {
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
