// SPDX-License-Identifier: Apache-2.0
#include "bus/health/device_health.hpp"

namespace mbgate::bus {
namespace {

// A device that answers may have so many damaged in a row before it is shown.
constexpr unsigned kDamagedInRow = 3;

}  // namespace

bool DeviceHealth::note_unanswered(Instant sent, Instant due, unsigned offline_after) {
  if (sent <= answered_sent_) {
    return false;
  }
  ++unanswered_in_row_;
  if (is_offline()) {
    return false;
  }
  const bool is_lost = offline_after != 0 && unanswered_in_row_ >= offline_after;
  state_.enter(is_lost ? DeviceState::offline : DeviceState::not_answering, due);
  return is_lost;
}

void DeviceHealth::note_damaged(Instant now) {
  const bool was_well = state() == DeviceState::answering && ++damaged_in_row_ < kDamagedInRow;
  if (!is_offline() && !was_well) {
    state_.enter(DeviceState::damaged, now);
  }
}

bool DeviceHealth::note_heard(Instant now) {
  unanswered_in_row_ = damaged_in_row_ = 0;
  return state_.enter(DeviceState::answering, now) == DeviceState::offline;
}

void DeviceHealth::forget_shown() {
  if (!is_offline()) {
    state_ = {};
  }
}

}  // namespace mbgate::bus
