// SPDX-License-Identifier: Apache-2.0
#include "bus/health/device_health.hpp"

#include <algorithm>

#include "modbus/response.hpp"

namespace mbgate::bus {
namespace {

constexpr int kMarginPart = 4;  // a quarter more than what was seen

// A device that answers may have so many damaged in a row before it is shown.
constexpr unsigned kDamagedInRow = 3;

constexpr int kAnswerTimes = 4;  // after so many answer times an owed answer was not just late

bool fits(const modbus::Request& asked, modbus::Bytes response) {
  return is_fitting(modbus::check_response(asked, response));
}

// An owed answer is read so late at most: no quarantine lasts longer, the time for which an adapter
// keeps bytes included.
Duration longest_lateness(const DeviceHealth::Timing& timing) {
  return std::max(timing.quarantine_max, timing.quarantine_or_default()) + kAdapterKeeps;
}

}  // namespace

bool DeviceHealth::note_unanswered(const modbus::Request& asked, Instant sent, Instant due,
                                   const Timing& timing) {
  owe(asked, due);
  if (sent <= answered_sent_) {
    return false;
  }
  ++unanswered_in_row_;
  if (is_offline()) {
    return false;
  }
  const bool is_lost = timing.offline_after != 0 && unanswered_in_row_ >= timing.offline_after;
  state_.enter(is_lost ? DeviceState::offline : DeviceState::not_answering, due);
  return is_lost;
}

void DeviceHealth::note_damaged(const modbus::Request& asked, Instant due, Instant now) {
  owe(asked, due);
  const bool was_well = state() == DeviceState::answering && ++damaged_in_row_ < kDamagedInRow;
  if (!is_offline() && !was_well) {
    state_.enter(DeviceState::damaged, now);
  }
}

void DeviceHealth::forget_shown() {
  damaged_in_row_ = 0;
  if (!is_offline()) {
    state_ = {};
  }
}

DeviceHealth::Debt& DeviceHealth::owe(const modbus::Request& asked, Instant due) {
  answered_at_.reset();
  if (forgotten_due_) {
    forgotten_due_ = std::max(*forgotten_due_, due);
  }
  const auto same = std::ranges::find_if(debts_, [&](const Debt& debt) {
    return !debt.given_up && !debt.outdated && debt.asked.pdu() == asked.pdu();
  });
  if (same != debts_.end()) {
    ++same->count;
    same->last_due = std::max(same->last_due, due);
    return *same;
  }
  if (debts_.size() >= kMostOwed) {
    const auto given_up = std::ranges::find_if(debts_, &Debt::given_up);
    const auto least =
        given_up == debts_.end() ? std::ranges::min_element(debts_, {}, &Debt::last_due) : given_up;
    if (!least->given_up) {
      forgotten_due_ = std::max(forgotten_due_.value_or(least->last_due), least->last_due);
      forgotten_.set(least->asked.function());
    }
    debts_.erase(least);
  }
  return debts_.emplace_back(Debt{asked, 1, due, due});
}

bool DeviceHealth::note_answered(const Answered& answered, Instant now) {
  pace_.note_answer(answered.took, now);
  answered_sent_ = std::max(answered_sent_, answered.sent);
  // Devices answer in order: what they did not answer before this comes no more, unless this was
  // it.
  std::erase_if(debts_, [&](Debt& debt) {
    return debt.given_up &&
           (std::exchange(debt.doubtful, true) || !fits(debt.asked, answered.response));
  });
  const auto replaced = std::ranges::find_if(debts_, [&](const Debt& debt) {
    return !debt.given_up && fits(debt.asked, answered.response);
  });
  if (replaced != debts_.end()) {
    const Duration suspected = std::max(replaced->suspected, now - replaced->due);
    if (replaced->count > 1) {
      --replaced->count;
      replaced->due = replaced->last_due;
    } else {
      debts_.erase(replaced);
    }
    Debt& owed = owe(answered.asked, answered.due);
    owed.suspected = std::max(owed.suspected, suspected);
  } else if (forgotten_.test(answered.asked.function())) {
    owe(answered.asked, answered.due);  // it may be the answer to what is not known any more
  }
  answered_at_ = now;
  return answer_seen(now);
}

bool DeviceHealth::answer_seen(Instant now) {
  unanswered_in_row_ = damaged_in_row_ = 0;
  return state_.enter(DeviceState::answering, now) == DeviceState::offline;
}

void DeviceHealth::note_asked(Instant now, const Timing& timing) {
  if (debts_.empty() && !forgotten_due_) {
    return;
  }
  const Duration longest = longest_lateness(timing);
  std::erase_if(debts_, [&](const Debt& debt) { return now > debt.last_due + longest; });
  for (Debt& debt : debts_) {
    debt.due = debt.due_at(now, longest);
    debt.given_up = debt.given_up || now >= held_until(debt.asked.function(), timing);
  }
  if (forgotten_due_ && now >= held_until(timing)) {
    forgotten_due_.reset();
    forgotten_.reset();
  }
}

void DeviceHealth::note_written() {
  std::ranges::for_each(debts_, [](Debt& debt) { debt.outdated = true; });
}

std::optional<DeviceHealth::Late> DeviceHealth::note_unexpected(modbus::Bytes response, Instant now,
                                                                const Timing& timing) {
  const Duration longest = longest_lateness(timing);
  const auto find = [&](bool given_up) {
    return std::ranges::find_if(debts_, [&](const Debt& debt) {
      return debt.given_up == given_up && now <= debt.last_due + longest &&
             fits(debt.asked, response);
    });
  };
  auto debt = find(false);
  if (debt == debts_.end()) {
    debt = find(true);
  }
  if (debt == debts_.end()) {
    return std::nullopt;
  }
  Late late{};
  late.lateness = std::max({now - debt->due_at(now, longest), debt->suspected, Duration{0}});
  if (debt->count > 1) {
    --debt->count;
    debt->due = debt->last_due;
  } else {
    debts_.erase(debt);
  }
  const Duration covering =
      std::min(late.lateness + late.lateness / kMarginPart, timing.quarantine_max);
  late.grew = covering > quarantine(now, timing);
  pace_.note_late(covering, now);
  late.back = answer_seen(now);
  return late;
}

unsigned DeviceHealth::owed(std::uint8_t function, Instant now, const Timing& timing) const {
  if (now >= held_until(function, timing)) {
    return 0;
  }
  unsigned count = 0;
  for (const Debt& debt : debts_) {
    count += !debt.given_up && debt.asked.function() == function ? debt.count : 0U;
  }
  return count;
}

unsigned DeviceHealth::owed_alike(const modbus::Request& write, Instant now,
                                  const Timing& timing) const {
  if (!write.writes() || now >= held_until(write.function(), timing)) {
    return 0;
  }
  unsigned count = 0;
  for (const Debt& debt : debts_) {
    const bool other = debt.outdated || debt.asked.pdu() != write.pdu();
    const bool alike =
        !debt.given_up && other && fits(write, modbus::echo_response(debt.asked).bytes());
    count += alike ? debt.count : 0U;
  }
  return count;
}

Instant DeviceHealth::end_of(const Debt& debt, const Timing& timing) const {
  return debt.given_up ? Instant::min() : held_if_unanswered(debt.last_due, timing);
}

Instant DeviceHealth::held_if_unanswered(Instant due, const Timing& timing) const {
  return due + quarantine(due, timing) + kAdapterKeeps;
}

Instant DeviceHealth::held_until(const Timing& timing) const {
  Instant until = Instant::min();
  if (forgotten_due_) {
    until = held_if_unanswered(*forgotten_due_, timing);
  }
  for (const Debt& debt : debts_) {
    until = std::max(until, end_of(debt, timing));
  }
  return until;
}

Instant DeviceHealth::held_until(std::uint8_t function, const Timing& timing) const {
  if (debts_.empty() && !forgotten_due_) {
    return Instant::min();
  }
  const Instant all = held_until(timing);
  if (!answered_at_ || forgotten_due_ || all == Instant::min()) {
    return all;
  }
  Instant same = Instant::min();
  for (const Debt& debt : debts_) {
    if (debt.asked.function() == function) {
      same = std::max(same, end_of(debt, timing));
    }
  }
  const Duration not_just_late = std::max(kAdapterKeeps, kAnswerTimes * pace_.longest_answer());
  return std::max(same, std::min(all, *answered_at_ + not_just_late));
}

Duration DeviceHealth::quarantine(Instant now, const Timing& timing) const {
  return std::max(timing.quarantine_or_default(),
                  std::min(pace_.learned(now), timing.quarantine_max));
}

}  // namespace mbgate::bus
