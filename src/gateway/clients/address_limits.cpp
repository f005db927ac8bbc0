// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/address_limits.hpp"

#include <algorithm>

#include "gateway/limits.hpp"

namespace mbgate::gateway {
bool AddressLimits::is_full(const ClientInfo& info, const ListenerSettings& listener) const {
  const auto known = entries_.find(place_of(info, listener));
  return known != entries_.end() &&
         known->second.connections >= listener.max_connections_per_address;
}

bool AddressLimits::comes_too_often(const ClientInfo& info, const ListenerSettings& listener,
                                    Instant now) const {
  const unsigned most = listener.max_connects_per_second;
  const auto known = entries_.find(place_of(info, listener));
  return known != entries_.end() && !known->second.connects.has_room(most, now);
}

void AddressLimits::came(const ClientSession& session, Instant now) {
  forget(now);
  Entry& entry = entries_[place_of(session)];
  ++entry.connections;
  entry.connects.take(session.listener().max_connects_per_second, now);
}

void AddressLimits::left(const ClientSession& session) {
  const auto known = entries_.find(place_of(session));
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

bool AddressLimits::may_ask(const ClientSession& session, Instant now) {
  const unsigned most = session.listener().max_requests_per_second;
  SecondRate& requests = entries_.at(place_of(session)).requests;
  const bool has_room = requests.has_room(most, now);
  if (has_room) {
    requests.take(most, now);
  }
  return has_room;
}

bool AddressLimits::may_be_reported(const ClientSession& session, Instant now) {
  std::optional<Instant>& reported_at = entries_.at(place_of(session)).reported_at;
  if (reported_at && now < *reported_at + kOverRateToldEvery) {
    return false;
  }
  reported_at = now;
  return true;
}

}  // namespace mbgate::gateway
