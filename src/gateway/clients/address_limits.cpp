// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/address_limits.hpp"

#include <algorithm>
#include <utility>

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
  return most > 0 && known != entries_.end() && known->second.connects.next(most, now) > now;
}

void AddressLimits::came(const ClientSession& session, Instant now) {
  forget(now);
  Entry& entry = entries_[place_of(session)];
  ++entry.connections;
  if (const unsigned most = session.listener().max_connects_per_second; most > 0) {
    entry.connects.take(most, now);
  }
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

bool AddressLimits::may_ask(ClientSession& session, Instant now) {
  const unsigned most = session.listener().max_requests_per_second;
  if (most == 0) {
    give_back(session, now);
    return true;
  }
  session.end_hold(now);
  if (session.has_turn || session.ahead.has(session.position())) {
    return true;
  }
  if (session.held_until) {
    return false;
  }
  Entry& entry = entries_.at(place_of(session));
  const Instant turn = entry.requests.take(most, now);
  if (turn <= now) {
    return true;
  }
  session.held_until = turn;
  session.is_in_line = true;
  entry.line.push_back({&session, turn, most});
  return false;
}

void AddressLimits::use_turn(ClientSession& session) {
  if (std::exchange(session.has_turn, false) && std::exchange(session.is_in_line, false)) {
    auto& line = entries_.at(place_of(session)).line;
    line.erase(std::ranges::find(line, &session, &Waiting::session));
  }
}

// Who waits behind it moves up: otherwise the next one to come would get the turn of the last. A
// turn that has come is over: later ones may have been used.
std::vector<ClientSession*> AddressLimits::give_back(ClientSession& session, Instant now) {
  session.held_until.reset();
  session.has_turn = false;
  if (!std::exchange(session.is_in_line, false)) {
    return {};
  }
  Entry& entry = entries_.at(place_of(session));
  const auto own = std::ranges::find(entry.line, &session, &Waiting::session);
  const Waiting given_back = *own;
  auto next = entry.line.erase(own);
  if (given_back.turn <= now) {
    return {};
  }
  entry.requests.give_back(given_back.per_second, given_back.turn);
  const unsigned most = session.listener().max_requests_per_second;
  std::vector<ClientSession*> moved;
  for (; next != entry.line.end(); ++next) {
    const Instant turn = most == 0 ? next->turn : entry.requests.next(most, now);
    if (turn < next->turn) {
      *next = {next->session, turn, most};
      next->session->held_until = turn;
      moved.push_back(next->session);
    }
    entry.requests.take(next->turn);
  }
  return moved;
}

bool AddressLimits::is_news(const ClientSession& session, Instant now) {
  std::optional<Instant>& told_at = entries_.at(place_of(session)).told_at;
  if (told_at && now < *told_at + kHeldToldEvery) {
    return false;
  }
  told_at = now;
  return true;
}

}  // namespace mbgate::gateway
