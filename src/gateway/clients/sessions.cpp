// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/sessions.hpp"

#include <algorithm>
#include <tuple>

namespace mbgate::gateway {
namespace {

// Who never asked, then who has nothing to do, for longest; then who connected first.
ClientSession* first_to_go(const std::vector<ClientSession*>& candidates) {
  const auto place = [](const ClientSession* it) {
    return std::tuple(it->has_asked, !it->is_at_rest(),
                      it->is_at_rest() ? it->last_activity : Instant::min(), it->id());
  };
  const auto first = std::ranges::min_element(candidates, {}, place);
  return first == candidates.end() ? nullptr : *first;
}

std::vector<ClientSession*> displaceable(Sessions& sessions, ListenerId listener) {
  std::vector<ClientSession*> all;
  for (ClientSession& session : sessions.open()) {
    if (session.info().listener == listener &&
        !session.listener().keep.contains(session.info().address, session.info().role)) {
      all.push_back(&session);
    }
  }
  return all;
}

}  // namespace

ClientSession* to_replace(Sessions& sessions, ListenerId listener, const ClientKey& client) {
  auto own = displaceable(sessions, listener);
  std::erase_if(own,
                [&](const ClientSession* it) { return it->key() != client || !it->is_at_rest(); });
  return first_to_go(own);
}

ClientSession* to_displace(Sessions& sessions, ListenerId listener, const ClientKey& newcomer) {
  auto all = displaceable(sessions, listener);
  std::map<ClientKey, std::size_t> counts{{newcomer, 1}};
  for (const ClientSession* session : all) {
    ++counts[session->key()];
  }
  const std::size_t most = std::ranges::max(counts | std::views::values);
  const bool is_newcomer = most > 1 && counts[newcomer] == most;
  std::erase_if(all, [&](const ClientSession* it) {
    const bool is_loser = is_newcomer ? it->key() == newcomer : counts[it->key()] == most;
    return !is_loser || (most == 1 && it->has_asked);
  });
  return first_to_go(all);
}

bool Sessions::is_full(ListenerId listener) const {
  return on(listener) >= settings_->listener(listener).max_connections;
}

std::size_t Sessions::on(ListenerId listener) const {
  return static_cast<std::size_t>(std::ranges::count_if(
      open(), [&](const ClientSession& it) { return it.info().listener == listener; }));
}

ClientSession* Sessions::add(ClientId client, const ClientInfo& info, Instant now) {
  const auto [entry, added] =
      sessions_.try_emplace(client, client, info, settings_->listener(info.listener), now);
  if (!added) {
    return nullptr;
  }
  ++counters(info.listener).connections;
  ClientSession& session = entry->second;
  session.turns = &add_connection(session);
  look_at(session, session.next_look(now));
  return &session;
}

ClientSession* Sessions::find(ClientId client) {
  const auto entry = sessions_.find(client);
  return entry == sessions_.end() || entry->second.is_closed ? nullptr : &entry->second;
}

const routing::ClientAddress* Sessions::address_of(bus::FairnessKey key) const {
  const auto found = std::ranges::find_if(
      addresses_, [key](const auto& it) { return it.second.turns.key == key; });
  return found == addresses_.end() ? nullptr : &found->second.first;
}

void Sessions::close(ClientSession& session) {
  session.is_closed = true;
  closed_.push_back(session.id());
  timers_.erase({session.timer_at, session.id()});
  const auto address = addresses_.find(session.key());
  if (--address->second.connections == 0) {
    free_keys_.push_back(address->second.turns.key);
    addresses_.erase(address);
  }
  session.turns = nullptr;
}

void Sessions::sweep() {
  for (const ClientId client : closed_) {
    sessions_.erase(client);
  }
  closed_.clear();
}

ClientSession* Sessions::take_ready() {
  while (!ready_.empty()) {
    ClientSession* const session = ready_.back();
    ready_.pop_back();
    if (!session->is_closed) {
      return session;
    }
  }
  return nullptr;
}

void Sessions::look_at(ClientSession& session, std::optional<Instant> at) {
  if (at && *at < session.timer_at) {
    timers_.erase({session.timer_at, session.id()});
    timers_.emplace(*at, session.id());
    session.timer_at = *at;
  }
}

ClientSession* Sessions::take_due(Instant now) {
  if (timers_.empty() || timers_.begin()->first > now) {
    return nullptr;
  }
  ClientSession& session = sessions_.at(timers_.extract(timers_.begin()).value().second);
  session.timer_at = Instant::max();
  return &session;
}

// Connections of one client share its turns. Key 0 is the gateway's.
const Turns& Sessions::add_connection(const ClientSession& session) {
  const bus::FairnessKey unused_key{static_cast<std::uint32_t>(addresses_.size() + 1)};
  const auto [known, is_new] = addresses_.try_emplace(session.key());
  Turns& turns = known->second.turns;
  ++known->second.connections;
  if (is_new) {
    known->second.first = session.info().address;
    turns = {unused_key, weight_of(session.info().address)};
    if (!free_keys_.empty()) {
      turns.key = free_keys_.back();
      free_keys_.pop_back();
    }
  }
  return turns;
}

unsigned Sessions::weight_of(const routing::ClientAddress& address) const {
  const auto& weights = settings_->weights;
  const auto fitting = std::ranges::find_if(
      weights, [&](const ClientWeight& it) { return it.network.contains(address); });
  return fitting == weights.end() ? 1 : fitting->weight;
}

void Sessions::clear_counters() {
  for (ClientSession& session : open()) {
    session.requests = session.refused = 0;
  }
  std::ranges::fill(counters_, ListenerCounters{});
}

void Sessions::adopt(const Settings& next, Instant now) {
  settings_ = &next;
  counters_.resize(next.listeners.size());
  for (ListenerCounters& counters : counters_) {
    counters.recent = {};  // it was of other devices, or times
  }
  for (ClientSession& session : open()) {
    session.adopt(next.listener(session.info().listener));
    session.note_reload(now);
    wake(session);  // to be served, and looked at by its new times
  }
  for (auto& [key, known] : addresses_) {
    known.turns.weight = weight_of(known.first);
  }
}

}  // namespace mbgate::gateway
