// SPDX-License-Identifier: Apache-2.0
// Clients that were there before the gateway, and those that it closes: because they hang within a
// request, have lost the framing, ask for nothing, or because others want their place.
#include <algorithm>
#include <utility>

#include "soak/client.hpp"

namespace mbgate::soak {

using namespace std::chrono_literals;

namespace {

constexpr Duration kLatestClose = 3s;  // that the process may be, and more
constexpr Duration kMostTries = 60s;
constexpr Duration kLongestFrameTimeout = 10s;  // that a reload may bring

}  // namespace

// What lies in its socket when the gateway begins is older than that: no write of it is carried
// out.
void Client::write_before_the_start() {
  if (!std::exchange(manners_.waits_at_start, false)) {
    return;
  }
  tools_.report.fault("waits_at_start");
  for (unsigned count = tools_.random.between(1U, 4U); count > 0; --count) {
    Asked asked = tools_.asking.make(manners_);
    if (asked.changes() && !asked.refused) {
      asked.kind = Kind::write;
      asked.stops_all = false;
      asked.replies = true;
      asked.refused = 6;  // unless it is denied, which its parts decide
    }
    write(std::move(asked));
    push(unwritten_.size());
  }
}

// It writes a part of a request, and nothing any more.
void Client::hang() {
  if (!unwritten_.empty()) {
    return;
  }
  tools_.report.fault("hang");
  is_silent_ = true;
  hangs_since_ = Instant::max();  // until the gateway reads it
  const std::vector<std::uint8_t> whole{0, 1, 0, 0, 0, 6, 1, 3, 0, 0, 0, 1};
  const auto size =
      static_cast<std::ptrdiff_t>(tools_.random.between<std::size_t>(1, whole.size() - 1));
  unwritten_.assign(whole.begin(), whole.begin() + size);
  made_ += unwritten_.size();
  frame_timeout_ = tools_.settings.listeners[manners_.listener].frame_timeout;
  push(unwritten_.size());
  be_closed_after(std::max<Duration>(frame_timeout_, kLongestFrameTimeout), "frame_timeout");
}

// A length that no MBAP header has, or RTU on the port of TCP.
void Client::lose_framing() {
  if (!unwritten_.empty()) {
    return;
  }
  tools_.report.fault("framing_lost");
  is_silent_ = framing_lost_ = true;
  unwritten_ = tools_.random.one_of<std::deque<std::uint8_t>>(
      {{0, 1, 0, 0, 0, 1, 1, 3}, {0, 1, 0, 0, 0, 255, 1, 3, 0}, {1, 3, 0, 0, 0, 1, 0x84, 0x0A}});
  made_ += unwritten_.size();
  push(unwritten_.size());
  be_closed_after(Duration{0}, "framing_lost");
}

// Once all is answered that it asked for. Its answers must be taken for that.
void Client::be_closed_after(Duration time, const char* kind) {
  const auto look = [this, kind, life = life_, until = tools_.schedule.now() + kMostTries] {
    if (life != life_ || !connected_ || vanished_ || half_closed_) {
      return;
    }
    const Instant now = tools_.schedule.now();
    const Duration idle = tools_.settings.listeners[manners_.listener].idle_timeout;
    const Duration limit =
        hangs_since_ ? std::max<Duration>(frame_timeout_, kLongestFrameTimeout) : idle;
    const Instant from =
        hangs_since_ ? active_ : std::max(active_, tools_.plan.idle_from[manners_.listener]);
    const bool is_limited = hangs_since_ || framing_lost_ || idle > Duration{0};
    if (is_limited && is_idle() && !paused_ && socket_.empty() &&
        now > from + limit + kLatestClose) {
      tools_.oracle.violation(
          kind, "the gateway keeps client " + std::to_string(static_cast<std::uint64_t>(number_)));
    } else if (now < until) {
      be_closed_after(1s, kind);
    }
  };
  tools_.schedule.after(time + kLatestClose, look);
}

bool Client::is_welcome() const {
  const auto& allowed = tools_.plan.allowed[manners_.listener];
  return tools_.listener(manners_.listener) &&
         lets_in_by_rules(tools_.plan, manners_.listener, manners_.host, manners_.role) &&
         (allowed.empty() || std::ranges::find(allowed, manners_.host) != allowed.end());
}

void Client::give_up() {
  connected_ = false;
  tools_.oracle.gone(number_);
  reconnect_later();
}

void Client::be_cut_off() {
  if (std::exchange(connected_, false)) {
    reconnect_later();
  }
}

bool Client::is_idle() const { return unconfirmed_ == 0 && tools_.oracle.is_idle(number_); }

bool Client::is_kept() const {
  const auto& kept = tools_.plan.kept[manners_.listener];
  return std::ranges::find(kept, manners_.host) != kept.end();
}

// Is anything a reason for the gateway to close it now?
bool Client::may_be_closed() const {
  const Instant now = tools_.schedule.now();
  const Duration idle = tools_.settings.listeners[manners_.listener].idle_timeout;
  const bool is_resting = idle > Duration{0} && now >= active_ + idle && unconfirmed_ == 0 &&
                          !tools_.oracle.has_outstanding(number_);
  const bool has_hung = hangs_since_ && *hangs_since_ != Instant::max() &&
                        now >= *hangs_since_ + std::min(frame_timeout_, kLeastFrameTimeout);
  return framing_lost_ || may_be_refused_ || has_hung || is_resting || tools_.is_stopping ||
         (tools_.full.listener == manners_.listener && may_be_displaced());
}

bool Client::may_be_found_lost() const {
  return framing_lost_ &&
         tools_.oracle.client_rates().may_have_held(number_, tools_.schedule.now());
}

// Where there are too many now, this one among them.
Crowded Client::crowd() const {
  const auto& limits = tools_.settings.listeners[manners_.listener];
  const auto count = [&](auto shares) {
    return static_cast<std::size_t>(std::ranges::count_if(
        tools_.all, [&](const Client& it) { return it.connected_ && (it.*shares)(*this); }));
  };
  if (count(&Client::shares_host) > limits.max_connections_per_address) {
    return {manners_.listener, manners_.host};
  }
  const bool is_full = count(&Client::shares_listener) > limits.max_connections;
  return {is_full ? manners_.listener : kNoListener};
}

// Which one makes room is not asked. Where the listener is full it is any that is not kept, also
// one with work; of a host that has too many, one of its own that has none. Else the newcomer is
// refused.
bool Client::may_be_displaced() const {
  const auto& host = tools_.full.host;
  if (is_connecting_ || !host) {
    return (!host || *host == manners_.host) && (is_connecting_ || !is_kept());
  }
  const bool has_outstanding = unconfirmed_ > 0 || tools_.oracle.has_outstanding(number_);
  return *host == manners_.host && !is_kept() && !has_outstanding;
}

// It waits for the answer to its last request for so long.
void Client::be_patient() {
  if (manners_.patience == Duration{0}) {
    return;
  }
  tools_.schedule.after(manners_.patience, [this, life = life_, transaction = transactions_] {
    if (life == life_ && connected_ && !vanished_ && asking_ &&
        tools_.oracle.is_open(number_, transaction)) {
      vanish();
    }
  });
}

}  // namespace mbgate::soak
