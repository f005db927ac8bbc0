// SPDX-License-Identifier: Apache-2.0
#include "bus/health/hold.hpp"

#include <algorithm>
#include <bit>
#include <utility>

#include "modbus/response.hpp"

namespace mbgate::bus {
namespace {

constexpr int kMarginPart = 4;  // a quarter more than what was seen
constexpr int kFastPart = 4;    // a fast device answers in a quarter of its response timeout

// Found by trying, with answer times that vary by a tenth.
constexpr int kHoldFactor = 2;

constexpr int kMostTails = 3;  // of the last eight
constexpr auto kTailsWithin = std::chrono::minutes(1);
constexpr auto kBetweenRests = std::chrono::minutes(10);

// Second answers are timed so often before the device is left alone for less than a whole response
// timeout after each answer, and forgotten after so many answers without one.
constexpr unsigned kTimedSeconds = 8;
constexpr unsigned kCleanAnswers = 200;

bool fits(const modbus::Request& asked, modbus::Bytes response) {
  return is_fitting(modbus::check_response(asked, response));
}

auto find(auto& unanswered, modbus::Bytes response) {
  return std::ranges::find_if(unanswered, [&](const auto& it) { return fits(it.asked, response); });
}

}  // namespace

void Hold::note_unanswered(const Sent& sent, bool is_unreadable) {
  pending_.reset();
  if (unanswered_.size() >= kMostUnanswered) {
    unanswered_.erase(unanswered_.begin());
  }
  unanswered_.emplace_back(Unanswered{sent.asked, sent.sent, sent.due, is_unreadable, sent.is_retry,
                                      sent.may_be_answered, sent.is_slow, sent.unit, limits_});
  unanswered_.back().suspected = std::exchange(suspected_, Duration{0});
}

void Hold::note_answered(const Sent& sent, modbus::Bytes response, Duration took, Instant now,
                         const Timing& timing) {
  settle(now - Duration{1}, timing);  // what came at the end of a tail came within it
  if (is_decisive_) {
    unanswered_.clear();
    held_until_.reset();
    tails_ = 0;
    rests_until_ = Instant::min();
  }
  const Instant oldest = oldest_unanswered(sent.sent);
  const auto earlier = find(unanswered_, response);
  // A device that answers this one at once, and nothing else, has no queue, and owes no more.
  const bool had_its_time = sent.is_probe || (held_until_ && !unanswered_.empty() &&
                                              unanswered_.back().sent < held_since_);
  const bool has_no_queue =
      earlier == unanswered_.end() && had_its_time && took * kFastPart < timing.response_timeout;
  Duration since_earlier{0};
  if (earlier != unanswered_.end()) {
    since_earlier = earlier->is_unreadable ? Duration{0} : sent.sent - earlier->sent;
    const Duration suspected = std::max(earlier->suspected, now - earlier->due);
    close(earlier, now, timing);
    suspected_ = std::max(suspected_, suspected);
    note_unanswered(sent);
    unanswered_.back().was_replaced = true;
  }
  pending_.reset();
  suspected_ = Duration{0};
  was_sudden_ = pace_.note_answer(took, took + since_earlier, now, !sent.is_slow);
  heard_at_ = now;
  if (answered_.size() == kMostAnswered) {
    answered_.erase(answered_.begin());
  }
  answered_.push_back({sent.asked, sent.unit, now});
  if (seconds_ > 0 && ++clean_ >= kCleanAnswers) {
    seconds_ = 0;
    longest_second_ = Duration{0};
  }
  if (!has_no_queue) {
    hold_for_rest(oldest, now, timing);
  }
}

void Hold::close(std::vector<Unanswered>::iterator answered, Instant now, const Timing& timing) {
  if (!answered->is_over) {
    note_tail(*answered, true, now, timing);
  }
  unanswered_.erase(answered);
}

Instant Hold::oldest_unanswered(Instant otherwise) const {
  const auto oldest = std::ranges::find(unanswered_, false, &Unanswered::may_be_answered);
  return oldest == unanswered_.end() ? otherwise : oldest->sent;
}

// No longer than anything is owed.
void Hold::hold_for_rest(Instant oldest_sent, Instant now, const Timing& timing) {
  held_until_.reset();
  held_since_ = now;
  const auto count =
      std::ranges::count(unanswered_, false, &Unanswered::may_be_answered) + (pending_ ? 1 : 0);
  if (count > 0) {
    held_until_ = now + std::min(kHoldFactor * count * (now - oldest_sent),
                                 timing.quarantine_max + kAdapterKeeps);
  }
}

bool Hold::note_asked(const modbus::Request* asked, Instant now, const Timing& timing,
                      bool forgets) {
  settle(now, timing);
  if (forgets && asked != nullptr && !(held_until_ && now < *held_until_)) {
    std::erase_if(unanswered_, [&](const Unanswered& it) {
      return it.is_over && !it.is_outdated && it.asked.pdu() == asked->pdu();
    });
  }
  const bool is_in_doubt = is_doubtful_ && !unanswered_.empty();
  is_decisive_ = is_in_doubt && asked != nullptr && asked->is_read();
  is_doubtful_ = is_in_doubt && !is_decisive_;
  pending_ = asked != nullptr ? std::optional(*asked) : std::nullopt;
  limits_ = {timing.quarantine_or_default(), timing.quarantine_max};
  suspected_ = Duration{0};
  return is_decisive_;
}

// What is not remembered any more: the tail is over, and the device had its time.
void Hold::settle(Instant now, const Timing& timing, bool was_held) {
  const bool is_held = was_held || (held_until_ && now < *held_until_);
  for (Unanswered& it : unanswered_) {
    if (!it.is_over && now >= end_of_tail(it, timing)) {
      it.is_over = true;
      note_tail(it, it.is_unreadable || it.was_replaced, now, timing);
    }
  }
  std::erase_if(unanswered_, [&](const Unanswered& it) {
    const bool was_waited_for = held_until_ && it.sent < held_since_;
    const Duration longest = std::max(it.limits.quarantine_max, timing.quarantine_max);
    return it.is_over && ((!is_held && (was_waited_for || it.is_unreadable)) ||
                          now >= it.sent + longest + kAdapterKeeps);
  });
}

// Where tails end without an answer several times in a minute, though the device answers others,
// its answers may be later than any tail: once it is left alone for long enough to hear them.
void Hold::note_tail(const Unanswered& ended, bool was_answered, Instant now,
                     const Timing& timing) {
  tails_ = static_cast<std::uint8_t>((unsigned{tails_} << 1U) | (was_answered ? 0U : 1U));
  if (was_answered) {
    return;
  }
  const Instant first = std::exchange(silent_[0], std::exchange(silent_[1], ended.sent));
  const bool has_rested = rested_at_ != Instant::min() && now < rested_at_ + kBetweenRests;
  if (std::popcount(tails_) >= kMostTails && ended.sent < first + kTailsWithin &&
      heard_at_ > first && !has_rested) {
    tails_ = 0;
    rested_at_ = now;
    rests_until_ = now + timing.quarantine_max;
  }
}

void Hold::note_written(const modbus::Request& write, bool is_stop) {
  constexpr std::size_t kEcho = 5;  // of 15 and 16 (Application Protocol V1.1b3, 6.11 and 6.12)
  const auto echo = write.pdu().bytes().first(std::min(kEcho, write.pdu().size()));
  for (Unanswered& it : unanswered_) {
    const bool is_other = it.asked.writes() && it.asked.pdu() != write.pdu();
    const bool is_alike = std::ranges::equal(
        it.asked.pdu().bytes().first(std::min(kEcho, it.asked.pdu().size())), echo);
    it.is_outdated = it.is_outdated || (is_other && (is_alike || !is_stop));
  }
}

std::optional<Hold::Late> Hold::note_late(modbus::Bytes response, Instant came,
                                          const Timing& timing, bool was_offline) {
  settle(came, timing, true);  // it may have come a while ago, when the device was held
  const auto found = find(unanswered_, response);
  if (found == unanswered_.end()) {
    return std::nullopt;
  }
  const Instant oldest = oldest_unanswered(came);
  const Duration seen = std::max({came - found->due, found->suspected, Duration{0}});
  Late late{seen, false, seen};
  // If it fits a later one too, it may be the answer to that, and this one's was lost. It is known
  // when one more comes.
  const auto later =
      std::ranges::find_if(unanswered_.rbegin(), unanswered_.rend(),
                           [&](const Unanswered& it) { return fits(it.asked, response); });
  if (pending_ && fits(*pending_, response)) {
    suspected_ = std::max(suspected_, seen);
    late.lateness = late.shown = Duration{0};
    is_doubtful_ = is_doubtful_ || was_offline;
  } else if (&*later != &*found) {
    later->suspected = std::max(later->suspected, seen);
    late.lateness = std::max(came - later->due, Duration{0});
    const auto first = std::ranges::find_if(later, std::prev(unanswered_.rend()),
                                            [](const Unanswered& it) { return !it.is_retry; });
    late.shown = std::max(came - first->due, Duration{0});
  }
  const Duration covering =
      std::min(late.lateness + late.lateness / kMarginPart, timing.quarantine_max);
  late.grew = covering > tail(came, timing);
  pace_.note_late(covering, came);
  if (late.lateness > Duration{0}) {
    const Duration took = late.lateness + timing.response_timeout;
    pace_.note_answer(took, took, came, !found->is_slow);
  }
  heard_at_ = came;
  close(found, came, timing);
  settle(came, timing);
  hold_for_rest(oldest, came, timing);
  return late;
}

bool Hold::note_second(modbus::Bytes response, Instant came, const Timing& timing) {
  const auto first = std::find_if(answered_.rbegin(), answered_.rend(), [&](const Answered& it) {
    return came <= it.at + timing.response_timeout && fits(it.asked, response);
  });
  if (first == answered_.rend()) {
    return false;
  }
  ++seconds_;
  clean_ = 0;
  longest_second_ = std::max(longest_second_, came - first->at);
  return true;
}

// A second answer to the last request may come until then; or its own, if what came suddenly was
// the second one to an earlier request.
Instant Hold::end_of_seconds(const Timing& timing) const {
  if (answered_.empty()) {
    return Instant::min();
  }
  const Instant answered_at = answered_.back().at;
  if (seconds_ == 0) {
    return was_sudden_ ? answered_at + pace_.longest_answer() + kAdapterKeeps : Instant::min();
  }
  const Duration learned = longest_second_ + longest_second_ / kMarginPart + kAdapterKeeps;
  return answered_at + (seconds_ < kTimedSeconds ? timing.response_timeout
                                                 : std::min(learned, timing.response_timeout));
}

// Only a stop is sent while a second answer is still to come.
OwedAnswers Hold::owed(const modbus::Request& next, std::uint8_t unit, Instant first_sent,
                       Instant now, const Timing& timing) const {
  OwedAnswers owed;
  const bool has_second = seconds_ > 0 && clean_ > 0 && now < end_of_seconds(timing);
  if (has_second && answered_.back().unit == unit &&
      answered_.back().asked.function() == next.function()) {
    owed.push_back({answered_.back().asked, false});
  }
  for (const Unanswered& it : unanswered_) {
    if (!is_decisive_ && it.unit == unit && it.asked.function() == next.function()) {
      const bool is_own = it.sent >= first_sent && !it.is_outdated && it.asked.pdu() == next.pdu();
      owed.push_back({it.asked, is_own});
    }
  }
  return owed;
}

Instant Hold::until(const Timing& timing) const {
  return end_of_tails(timing, [](const Unanswered&) { return true; });
}

template <typename Predicate>
Instant Hold::end_of_tails(const Timing& timing, Predicate holds, bool decides) const {
  const Instant held = std::max(held_until_.value_or(Instant::min()), rests_until_);
  const Instant begin = decides ? heard_at_ + timing.response_timeout + kAdapterKeeps : held;
  const Duration longer = decides ? timing.response_timeout : Duration{0};  // in doubt
  Instant until = std::max(begin, end_of_seconds(timing));
  for (const Unanswered& it : unanswered_) {
    until = holds(it) ? std::max(until, end_of_tail(it, timing) + longer) : until;
  }
  return until;
}

Instant Hold::until(const modbus::Request& next, const Timing& timing, bool repeats) const {
  const bool is_fast = !unanswered_.empty() && heard_at_ > unanswered_.back().sent &&
                       pace_.longest_answer() * kFastPart < timing.response_timeout;
  const auto is_same = [&](const Unanswered& it) { return it.asked.function() == next.function(); };
  const bool decides = is_doubtful_ && next.is_read();
  if (!decides && (repeats || (is_fast && std::ranges::none_of(unanswered_, is_same)))) {
    return repeats ? Instant::min() : end_of_seconds(timing);
  }
  const auto holds = [&](const Unanswered& it) {
    return decides ? is_same(it) && it.asked.pdu() != next.pdu()
                   : !it.may_be_answered || is_same(it);
  };
  return end_of_tails(timing, holds, decides);
}

Duration Hold::tail(Instant now, const Timing& timing) const {
  return std::max(timing.quarantine_or_default(),
                  std::min(pace_.learned(now), timing.quarantine_max));
}

}  // namespace mbgate::bus
