// SPDX-License-Identifier: Apache-2.0
#include <algorithm>

#include "bus/health/line_diagnosis.hpp"

namespace mbgate::bus {
namespace {

constexpr Duration kLoadWindow = std::chrono::seconds(10);

unsigned share(Duration part, Duration of) {
  constexpr Duration::rep kPercent = 100;
  return of <= Duration{0}
             ? 0
             : static_cast<unsigned>(std::min(part * kPercent / of, Duration::rep{kPercent}));
}

}  // namespace

void LineLoad::note(bool is_busy, Instant now, Instant free_at) {
  if (is_busy == busy_since_.has_value()) {
    return;
  }
  window_began_ = window_began_.value_or(now);
  go_on(now);
  if (is_busy) {
    busy_since_ = std::max(now, counted_until_);
  } else {
    end_busy(std::max(now, free_at));
    busy_since_.reset();
  }
}

void LineLoad::note_wait(Duration waited, Instant now) {
  window_began_ = window_began_.value_or(now);
  go_on(now);
  ++waits_.all;
  waits_.are_long += waited >= kLongWait ? 1U : 0U;
}

// The line may be used earlier than was expected: a connection that its server usually closes.
void LineLoad::end_busy(Instant at) {
  const Duration more = std::max(at - *busy_since_, Duration{0});
  busy_ += more;
  total_ += more;
  counted_until_ = std::max(counted_until_, at);
}

Duration LineLoad::total(Instant now) const {
  return total_ + (busy_since_ ? std::max(now - *busy_since_, Duration{0}) : Duration{0});
}

// Windows that are over by now are closed.
void LineLoad::go_on(Instant now) {
  while (now - *window_began_ >= kLoadWindow) {
    const Instant end = *window_began_ + kLoadWindow;
    if (busy_since_) {
      end_busy(end);
      busy_since_ = std::max(end, counted_until_);
    }
    // Nothing happens in the windows of a long pause.
    const bool was_long = now - end >= 2 * kLoadWindow && !busy_since_;
    before_ = was_long ? Duration{0} : busy_;
    busy_ = Duration{0};
    waits_before_ = was_long ? LineWaits{} : waits_;
    waits_ = {};
    window_began_ = was_long ? now : end;
  }
}

unsigned LineLoad::percent(Instant now) const {
  if (!window_began_) {
    return 0;
  }
  LineLoad at_now = *this;
  at_now.go_on(now);
  if (at_now.before_) {
    return share(*at_now.before_, kLoadWindow);
  }
  const Duration running =
      at_now.busy_since_ ? std::max(now - *at_now.busy_since_, Duration{0}) : Duration{0};
  return share(at_now.busy_ + running, now - *at_now.window_began_);
}

LineWaits LineLoad::waits(Instant now) const {
  if (!window_began_) {
    return {};
  }
  LineLoad at_now = *this;
  at_now.go_on(now);
  return at_now.before_ ? at_now.waits_before_ : at_now.waits_;
}

}  // namespace mbgate::bus
