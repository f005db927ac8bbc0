// SPDX-License-Identifier: Apache-2.0
#include "bus/health/line_quality.hpp"

#include <algorithm>
#include <bit>
#include <utility>

namespace mbgate::bus {
namespace {

constexpr unsigned kMostAnswers = 200;  // counted; then all counts are halved
constexpr unsigned kLeastBad = 5;
constexpr unsigned kBadPart = 20;   // a twentieth is bad
constexpr unsigned kGoodPart = 50;  // less than a fiftieth is good again

constexpr unsigned kWindow = 16;    // requests that lateness is counted in
constexpr unsigned kLeastLate = 4;  // of these
constexpr int kLateMargin = 4;      // a quarter more than what was seen
constexpr Duration kTimeoutStep = std::chrono::milliseconds(10);

// A device takes about the same time for each answer; noise comes at any time. Of answers whose
// times differ more, more are needed.
constexpr unsigned kLeastUnreadable = 5;
constexpr Duration kSameTime = std::chrono::milliseconds(20);
constexpr unsigned kLeastScattered = 12;
constexpr Duration kScattered = std::chrono::milliseconds(60);

}  // namespace

void CrcShare::note(bool bad) {
  if (all_ == kMostAnswers) {
    all_ /= 2;
    bad_ /= 2;
  }
  ++all_;
  bad_ += bad ? 1U : 0U;
  bad_now_ = bad_now_ ? bad_ * kGoodPart >= all_ : bad_ >= kLeastBad && bad_ * kBadPart >= all_;
}

void AnswerQuality::note_ended(bool in_time) {
  requests_ = (requests_ << 1U) & ((1U << kWindow) - 1U);
  most_requests_ = std::min(most_requests_ + 1, kWindow);
  late_since_ended_ = false;
  if (requests_ == 0) {
    lateness_ = needed_ = Duration{0};
  }
  if (in_time) {
    unreadable_in_row_ = 0;
  }
}

void AnswerQuality::note_answered() {
  note_ended(true);
  crcs_.note(false);
  has_answered_ = has_framed_ = true;
  judge();
}

// Unit, function and length were right: it is a frame.
void AnswerQuality::note_damaged() {
  note_ended(true);
  crcs_.note(true);
  has_framed_ = true;
  judge();
}

void AnswerQuality::note_silent() {
  note_ended(false);
  unreadable_in_row_ = 0;
  judge();
}

void AnswerQuality::note_unreadable(Duration after, unsigned unasked) {
  note_ended(false);
  const Duration first = std::min(first_after_, after);
  const Duration last = std::max(last_after_, after);
  if (unreadable_in_row_ == 0 || last - first > kScattered || unasked != unasked_before_) {
    unreadable_in_row_ = 1;
    first_after_ = last_after_ = after;
    unasked_before_ = unasked;
  } else {
    ++unreadable_in_row_;
    first_after_ = first;
    last_after_ = last;
  }
  judge();
}

void AnswerQuality::note_late(Duration lateness, Duration response_timeout) {
  has_answered_ = has_framed_ = true;
  if (most_requests_ == 0 || std::exchange(late_since_ended_, true)) {
    return;
  }
  requests_ |= 1U;
  lateness_ = std::max(lateness_, lateness);
  const Duration enough = response_timeout + lateness_ + lateness_ / kLateMargin;
  needed_ = (enough + kTimeoutStep - Duration{1}) / kTimeoutStep * kTimeoutStep;
  judge();
}

void AnswerQuality::forget() {
  const bool answered = has_answered_;
  *this = {};
  has_answered_ = answered;
}

void AnswerQuality::judge() {
  const auto late = static_cast<unsigned>(std::popcount(requests_));
  const bool was_late = verdict_.quality == Quality::late;
  if (crcs_.is_bad()) {
    verdict_ = crcs_.verdict();
    return;
  }
  const bool is_steady = last_after_ - first_after_ <= kSameTime;
  if (!has_framed_ && unreadable_in_row_ >= (is_steady ? kLeastUnreadable : kLeastScattered)) {
    verdict_ = {Quality::no_frame, unreadable_in_row_, unreadable_in_row_};
  } else if (late >= kLeastLate || (was_late && late > 0)) {
    verdict_ = {Quality::late, late, most_requests_, lateness_, needed_};
  } else if (has_answered_ && crcs_.is_known()) {
    verdict_ = crcs_.verdict();
  } else if (has_framed_ || unreadable_in_row_ == 0) {
    verdict_ = {};  // what it was based on is gone
  }
}

void LineQuality::forget() {
  for (AnswerQuality& device : devices_) {
    device.forget();
  }
  reported_ = {};
  crcs_ = {};
  line_reported_ = Quality::unknown;
}

void LineQuality::forget(std::uint8_t address) {
  devices_.at(address) = {};
  reported_.at(address) = Quality::unknown;
}

QualityVerdict LineQuality::verdict() const {
  QualityVerdict verdict = crcs_.verdict();
  if (!crcs_.is_known()) {
    verdict.quality = Quality::unknown;
  } else if (crcs_.is_bad() && std::ranges::count(reported_, Quality::bad_crc) < 2) {
    verdict.quality = Quality::good;
  }
  return verdict;
}

std::optional<QualityNotice> LineQuality::take_change(std::uint8_t address) {
  const auto is_reportable = [](Quality before, Quality now) {
    return before != now && (before != Quality::unknown || now != Quality::good);
  };
  const QualityVerdict& device = devices_.at(address).verdict();
  const Quality before = reported_.at(address);
  const Quality now = device.quality == Quality::unknown ? before : device.quality;
  reported_.at(address) = now;
  if (is_reportable(before, now)) {
    return QualityNotice{address, device};
  }
  const QualityVerdict line = verdict();
  if (is_reportable(std::exchange(line_reported_, line.quality), line.quality)) {
    return QualityNotice{std::nullopt, line};
  }
  return std::nullopt;
}

}  // namespace mbgate::bus
