// SPDX-License-Identifier: Apache-2.0
#include "bus/link_state.hpp"

#include <algorithm>

namespace mbgate::bus {
namespace {

constexpr int kBackoffFactor = 2;

}  // namespace

void LinkState::note_opened(Instant now) {
  state_ = State::open;
  opened_at_ = now;
  reopen_at_.reset();
}

void LinkState::note_lost(const BusSettings& settings, Instant now) {
  if (is_open() && !is_new(settings, now)) {
    // A line that dies as soon as it is open gets no such favour.
    delay_ = settings.reopen_min;
  }
  state_ = State::closed;
  reopen_at_ = now + delay_;
  delay_ = std::min(delay_ * kBackoffFactor, settings.reopen_max);
}

void LinkState::rest(const BusSettings& settings, bool answered) {
  state_ = State::resting;
  delay_ = answered ? settings.reopen_min : delay_;
}

void LinkState::hurry(const BusSettings& settings, Instant now) {
  if (reopen_at_) {
    reopen_at_ = std::min(*reopen_at_, std::max(now, tried_at_ + settings.reopen_min));
  }
}

bool LinkState::take_due(Instant now) {
  if (!reopen_at_ || now < *reopen_at_) {
    return false;
  }
  reopen_at_.reset();
  tried_at_ = now;
  return true;
}

}  // namespace mbgate::bus
