// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/address_limits.hpp"

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
  if (entries_.size() >= forgets_at_) {
    std::erase_if(entries_, [now](const auto& known) {
      const Entry& it = known.second;
      return it.connections == 0 && it.connects.is_rested(now) && it.requests.is_rested(now);
    });
    forgets_at_ = 2 * entries_.size() + kFewAddresses;
  }
  Entry& entry = entries_[place_of(session)];
  ++entry.connections;
  entry.connects.take(session.listener().max_connects_per_second, now);
}

void AddressLimits::left(const ClientSession& session) {
  --entries_.at(place_of(session)).connections;
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

}  // namespace mbgate::gateway
