// SPDX-License-Identifier: Apache-2.0
#include "soak/client_rates.hpp"

#include <algorithm>
#include <utility>

namespace mbgate::soak {
namespace {

using namespace std::chrono_literals;

constexpr Duration kSecond = 1s;
constexpr Duration kOneNanosecondEach = 1us;  // a part of a second is no whole number of them

// When there is room for one more: so many at once as the rate says.
Instant room_at(Instant counted_until, unsigned rate, Instant now) {
  return std::max(counted_until, now) + kSecond / static_cast<int>(rate) - kSecond;
}

void add(std::vector<Instant>& times, Instant time) {
  times.insert(std::ranges::upper_bound(times, time), time);
}

// Until when so many count that came then.
Instant counted(const std::vector<Instant>& times, unsigned rate) {
  Instant until = Instant::min();
  for (const Instant at : times) {
    until = room_at(until, rate, at) + kSecond;
  }
  return until;
}

// The gateway itself answers it, at once; 06 may come of what it met later.
bool is_answered_at_once(const Asked& asked) {
  constexpr std::uint8_t kBusy = 6;
  return (asked.refused.value_or(kBusy) != kBusy || asked.kind == Kind::own) && !asked.ordered &&
         !asked.dropped;
}

}  // namespace

ClientRates::ClientRates(const SoakPlan& plan) : plan_(plan) {
  for (std::size_t listener = 0; listener < plan.settings.listeners.size(); ++listener) {
    limits_.push_back(limits_of(listener));
  }
}

ClientRates::Limits ClientRates::limits_of(std::size_t listener) const {
  const auto& settings = plan_.settings.listeners[listener];
  return plan_.absent.listeners[listener]
             ? Limits{}
             : Limits{settings.max_connects_per_second, settings.max_requests_per_second,
                      settings.pipeline};
}

std::optional<bool> ClientRates::lets_in(std::size_t listener, unsigned host, Instant now) const {
  const unsigned rate = limits_[listener].connects;
  const auto known = buckets_.find({listener, host});
  if (rate == 0 || known == buckets_.end()) {
    return true;
  }
  const Instant at = room_at(known->second.connected_until, rate, now);
  const Instant anew = room_at(known->second.connected_anew, rate, now);
  if (at + kOneNanosecondEach <= now) {
    return true;
  }
  return anew > now + kOneNanosecondEach ? std::optional(false) : std::nullopt;
}

// One that is refused does not count.
void ClientRates::let_in(std::size_t listener, unsigned host, Instant now) {
  if (const unsigned rate = limits_[listener].connects; rate > 0) {
    Bucket& bucket = buckets_[{listener, host}];
    for (Instant* until : {&bucket.connected_until, &bucket.connected_anew}) {
      *until = room_at(*until, rate, now) + kSecond;
    }
  }
}

void ClientRates::came(ClientId client, std::size_t listener, unsigned host) {
  clients_[client] = {listener, host};
}

unsigned ClientRates::rate_of(const Asked& asked) const {
  return limits_[clients_.at(asked.client).first].requests;
}

ClientRates::Bucket& ClientRates::bucket_of(const Asked& asked) {
  return buckets_[clients_.at(asked.client)];
}

void ClientRates::share(Bucket& bucket) {
  bucket.is_shared = true;
  ++bucket.order;
}

void ClientRates::begun(Asked& asked, Instant now) {
  Bucket& bucket = bucket_of(asked);
  if (bucket.open++ == 0) {
    bucket.only = asked.client;
    bucket.taken_until = Instant::min();
  } else if (bucket.only != asked.client && !bucket.is_shared) {
    share(bucket);
  }
  asked.begun = now;
}

// The place for it is given when it is the next one of its connection. A stop has none when it
// finds the others held up; that it counts all the same errs to the permissive side.
void ClientRates::accepted(Asked& asked, Instant now) {
  const unsigned rate = asked.begun ? rate_of(asked) : 0;
  if (rate == 0) {
    return;
  }
  Bucket& bucket = bucket_of(asked);
  if (bucket.is_shared) {
    asked.ahead = asked.ahead || !asked.is_stop();
    return;
  }
  const Instant next = std::max(now, bucket.taken_until);
  const Instant place = room_at(bucket.counted_until, rate, next);
  bucket.counted_until = place + kSecond;
  bucket.taken_until = std::max({place, bucket.taken_until, now});
  if (!asked.ahead) {
    asked.held_until = bucket.taken_until;
    asked.held_in_order = bucket.order;
  }
  asked.ahead = asked.ahead || (bucket.taken_until > now && !asked.is_stop());
}

// Those that are held up may have to wait until its client has its answer. How late they are taken
// then nobody can tell, nor when there is room for those behind them.
void ClientRates::went_ahead(const Asked& stop) { share(bucket_of(stop)); }

Instant ClientRates::waits_since(const Asked& asked) const {
  const auto client = clients_.find(asked.client);
  const bool may_be_held = plan_.limits_hosts && client != clients_.end();
  const auto bucket = may_be_held ? buckets_.find(client->second) : buckets_.end();
  return bucket == buckets_.end() ? Instant::min() : bucket->second.answered;
}

bool ClientRates::may_hold(const Asked& asked, Duration lateness, Instant now) {
  const bool may_be_held =
      asked.ahead || (asked.held_until && now <= *asked.held_until + 2 * lateness);
  return asked.begun && may_be_held && !asked.surely_on_wire;
}

void ClientRates::lifted(Asked& asked, Instant now) const {
  if (asked.held_until && rate_of(asked) == 0) {
    asked.held_until = std::min(*asked.held_until, now);
  }
}

std::string ClientRates::answered(const Asked& asked, Duration lateness, Instant now) {
  if (!asked.begun) {
    return "";
  }
  Bucket& bucket = bucket_of(asked);
  bucket.answered = now;
  if (asked.is_stop()) {
    bucket.stopped = std::min(bucket.stopped, *asked.begun);
    return "";
  }
  const bool is_late = asked.held_until && now > *asked.held_until + 2 * lateness;
  if (is_late && asked.held_in_order == bucket.order && is_answered_at_once(asked)) {
    return "held_too_long";
  }
  const unsigned rate = rate_of(asked);
  return rate > 0 && !asked.passes_hold && *asked.begun > bucket.since &&
                 is_too_soon(bucket, asked, rate, now)
             ? "not_held"
             : "";
}

// As if all that were answered by now had been taken as soon as they came, in the best of orders.
// A place that was given to a stop, which needs none, is that of whatever came behind it.
bool ClientRates::is_too_soon(Bucket& bucket, const Asked& asked, unsigned rate, Instant now) {
  auto& times = bucket.let_through;
  add(times, std::min(*asked.begun, bucket.stopped));
  const Instant counted_until = counted(times, rate);
  const bool is_too_soon = counted_until - kSecond > now + kOneNanosecondEach;
  if (bucket.open <= 1 && counted_until <= now) {
    times.clear();  // as after a pause
    bucket.stopped = Instant::max();
  }
  return is_too_soon;
}

bool ClientRates::may_have_its_turn(const Asked& asked, Instant now) {
  const unsigned rate = asked.begun && !asked.is_stop() ? rate_of(asked) : 0;
  if (rate == 0) {
    return false;
  }
  const Bucket& bucket = bucket_of(asked);
  auto times = bucket.let_through;
  add(times, std::min(*asked.begun, bucket.stopped));
  return counted(times, rate) - kSecond <= now + kOneNanosecondEach;
}

bool ClientRates::may_have_held(ClientId client, Instant now) const {
  const Key& key = clients_.at(client);
  const auto known = buckets_.find(key);
  return limits_[key.first].requests > 0 && known != buckets_.end() &&
         (known->second.open > 0 || known->second.answered == now);
}

// Once nothing of the host is left in the gateway, all of it was taken by now.
void ClientRates::closed(const Asked& asked, Instant now) {
  if (!asked.begun) {
    return;
  }
  Bucket& bucket = bucket_of(asked);
  if (--bucket.open == 0 && bucket.is_shared) {
    bucket.is_shared = false;
    bucket.counted_until = now + (std::exchange(bucket.was_changed, false) ? 2 : 1) * kSecond;
  }
}

// Those that are held up have their places by the old limit; nobody says whether what was counted
// is forgotten. Behind a pipeline that has become shorter they wait for that too.
void ClientRates::after_reload(Instant now) {
  for (std::size_t listener = 0; listener < limits_.size(); ++listener) {
    const Limits before = std::exchange(limits_[listener], limits_of(listener));
    if (before == limits_[listener]) {
      continue;
    }
    for (auto& [key, bucket] : buckets_) {
      if (key.first != listener) {
        continue;
      }
      bucket.connected_anew = Instant::min();
      bucket.let_through.clear();
      bucket.since = now;
      const bool may_wait =
          limits_[listener].requests > 0 || limits_[listener].pipeline < before.pipeline;
      if (bucket.open > 0 && may_wait) {
        share(bucket);
        bucket.was_changed = true;
      }
    }
  }
}

}  // namespace mbgate::soak
