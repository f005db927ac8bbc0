// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/address_limits.hpp"

#include <algorithm>

#include "gateway/limits.hpp"

namespace mbgate::gateway {
bool AddressLimits::is_full(const ClientInfo& info, const ListenerSettings& listener) const {
  const auto known = entries_.find(key_of(info));
  return known != entries_.end() &&
         known->second.connections >= listener.max_connections_per_address;
}

bool AddressLimits::comes_too_often(const ClientInfo& info, const ListenerSettings& listener,
                                    Instant now) const {
  const unsigned most = listener.max_connects_per_second;
  const auto known = entries_.find(key_of(info));
  return most > 0 && known != entries_.end() && known->second.connects.next(most, now) > now;
}

void AddressLimits::came(const ClientInfo& info, const ListenerSettings& listener, Instant now) {
  forget(now);
  Entry& entry = entries_[key_of(info)];
  ++entry.connections;
  if (listener.max_connects_per_second > 0) {
    entry.connects.take(listener.max_connects_per_second, now);
  }
}

void AddressLimits::left(ClientSession& session) {
  give_back(session);
  const auto known = entries_.find(key_of(session.info()));
  Entry& entry = known->second;
  if (--entry.connections == 0) {
    const Instant rested = std::max(entry.connects.rested_at(), entry.requests.rested_at());
    leaving_.emplace_back(rested, known->first);
  }
}

// Later ones may have rested before the first has; they go with it.
void AddressLimits::forget(Instant now) {
  while (!leaving_.empty() && leaving_.front().first <= now) {
    const auto known = entries_.find(leaving_.front().second);
    leaving_.pop_front();
    if (known == entries_.end() || known->second.connections > 0) {
      continue;  // it has come again
    }
    if (known->second.connects.is_rested(now) && known->second.requests.is_rested(now)) {
      entries_.erase(known);
    }
  }
}

bool AddressLimits::may_ask(ClientSession& session, Instant now) {
  const unsigned most = session.listener().max_requests_per_second;
  if (most == 0) {
    session.held_until.reset();
    return true;
  }
  session.end_hold(now);
  if (session.has_turn || session.ahead.goes_on(session.position())) {
    return true;
  }
  if (session.held_until) {
    return false;
  }
  const Instant turn = entries_.at(key_of(session.info())).requests.take(most, now);
  session.turn_rate = most;
  session.held_until = turn;
  session.end_hold(now);
  return session.has_turn;
}

void AddressLimits::give_back(ClientSession& session) {
  if (session.held_until || session.has_turn) {
    entries_.at(key_of(session.info())).requests.give_back(session.turn_rate);
    session.held_until.reset();
    session.has_turn = false;
  }
}

bool AddressLimits::is_news(const ClientInfo& info, Instant now) {
  std::optional<Instant>& told_at = entries_.at(key_of(info)).told_at;
  if (told_at && now < *told_at + kHeldToldEvery) {
    return false;
  }
  told_at = now;
  return true;
}

}  // namespace mbgate::gateway
