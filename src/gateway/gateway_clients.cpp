// SPDX-License-Identifier: Apache-2.0
// The doors of the machine for clients: who is let in, when a connection is read, when it ends.
#include <algorithm>
#include <utility>

#include "gateway/gateway.hpp"

namespace mbgate::gateway {

void Gateway::handle_client_connected(ClientId client, const ClientInfo& info, Instant now) {
  if (!admit(info)) {
    actions_.push(Close{client});
    return;
  }
  auto& count = listener_clients_[static_cast<std::size_t>(info.listener)];
  ++count;
  const auto [entry, added] =
      sessions_.try_emplace(client, info, settings().listener(info.listener), now);
  add_connection(info.address);
  failsafe_.client_came(client, current().watched_for(info, entry->second.rights()));
  if (added && entry->second.listener().idle_timeout > Duration{0}) {
    arm(client, entry->second, now + entry->second.listener().idle_timeout);
  }
  settle(now);  // whoever made room for it may have been the last that may write
}

bool Gateway::admit(const ClientInfo& info) {
  const ListenerSettings& listener = settings().listener(info.listener);
  if (stopping_) {
    report(ClientRefused{info.listener, info.address, RefusalReason::stopping});
    return false;
  }
  if (!listener.allow.empty() && !routing::contains(listener.allow, info.address)) {
    report(ClientRefused{info.listener, info.address, RefusalReason::not_allowed});
    return false;
  }
  const bool full =
      listener_clients_[static_cast<std::size_t>(info.listener)] >= listener.max_connections;
  if (full && !displace_idle_client(info.listener)) {
    report(ClientRefused{info.listener, info.address, RefusalReason::full});
    return false;
  }
  return true;
}

bool Gateway::displace_idle_client(ListenerId listener) {
  auto idlest = sessions_.end();
  for (auto entry = sessions_.begin(); entry != sessions_.end(); ++entry) {
    const ClientSession& session = entry->second;
    const bool may_go = session.info().listener == listener && session.outstanding() == 0 &&
                        !routing::contains(session.listener().keep, session.info().address);
    if (may_go &&
        (idlest == sessions_.end() || session.last_activity < idlest->second.last_activity)) {
      idlest = entry;
    }
  }
  if (idlest == sessions_.end()) {
    return false;
  }
  report(ClientDisplaced{listener, idlest->second.info().address});
  close(idlest->first);
  return true;
}

void Gateway::handle_client_bytes(ClientId client, modbus::Bytes bytes, Instant now,
                                  std::size_t unread) {
  const auto entry = sessions_.find(client);
  if (entry == sessions_.end()) {
    return;
  }
  ClientSession& session = entry->second;
  if (!bytes.empty()) {
    session.last_activity = now;
  }
  if (!session.has_asked) {
    notice_rtu(session, bytes);  // some RTU frames can be read as MBAP
  }
  const Instant arrival = session.arrival_of(bytes.size(), unread, now);
  if (session.input.empty()) {
    const std::size_t taken = take_requests(client, session, bytes, arrival, now);
    if (!sessions_.contains(client)) {
      settle(now);
      return;
    }
    session.input.append(bytes.subspan(taken), arrival);
  } else {
    session.input.append(bytes, arrival);
  }
  ready_clients_.push_back(client);
  settle(now);
}

void Gateway::handle_client_sent(ClientId client, Instant now) {
  const auto entry = sessions_.find(client);
  if (entry == sessions_.end()) {
    return;
  }
  entry->second.confirm_sent();
  entry->second.last_activity = now;
  ready_clients_.push_back(client);
  settle(now);
}

void Gateway::handle_client_half_closed(ClientId client, Instant now) {
  const auto entry = sessions_.find(client);
  if (entry == sessions_.end()) {
    return;
  }
  entry->second.half_close();
  const auto exchanges = entry->second.exchanges;  // cancelling takes them out
  for (const std::uint32_t index : exchanges) {
    cancel_waiting(index, true);
  }
  ready_clients_.push_back(client);
  settle(now);
}

void Gateway::handle_client_disconnected(ClientId client, Instant now) {
  if (const auto entry = sessions_.find(client); entry != sessions_.end()) {
    take_stops_ahead(client, entry->second, now, true);
    forget(entry);
  }
  settle(now);
}

void Gateway::after_input(ClientId id, ClientSession& session, Instant now) {
  take_input(id, session, now);
  const auto entry = sessions_.find(id);
  if (entry == sessions_.end()) {
    return;
  }
  take_stops_ahead(id, session, now);
  failsafe_.client_waits(id, !session.exchanges.empty(), now);
  if (session.is_finished()) {
    close(id);
    return;
  }
  if (const auto reading = session.update_reading(now)) {
    if (*reading == ClientSession::Reading::pause) {
      actions_.push(Pause{id});
    } else {
      actions_.push(Resume{id});
    }
  }
  const bool partial = !session.input.empty() && !session.is_full();
  if (!partial) {
    session.partial_since.reset();
  } else if (!session.partial_since) {
    session.partial_since = now;
    arm(id, session, now + session.listener().frame_timeout);
  }
}

void Gateway::arm(ClientId id, ClientSession& session, Instant at) {
  if (!session.timer_armed_at || at < *session.timer_armed_at) {
    timers_.set(id, session.timer_armed_at, at);
    session.timer_armed_at = at;
  }
}

void Gateway::check_client(ClientId id, Instant now) {
  ClientSession& session = sessions_.at(id);
  session.timer_armed_at.reset();
  const ListenerSettings& listener = session.listener();
  if (session.partial_since) {
    const Instant limit = *session.partial_since + listener.frame_timeout;
    if (now >= limit) {
      report(ClientFrameTimedOut{session.info().listener, session.info().address});
      close(id);
      return;
    }
    arm(id, session, limit);
  }
  if (listener.idle_timeout > Duration{0}) {
    const Instant active = session.outstanding() > 0 ? now : session.last_activity;
    if (now >= active + listener.idle_timeout) {
      close(id);
      return;
    }
    arm(id, session, active + listener.idle_timeout);
  }
}

void Gateway::close(ClientId id) {
  actions_.push(Close{id});
  forget(sessions_.find(id));
}

// Nobody is told what becomes of its requests.
void Gateway::drop_requests(ClientSession& session) {
  for (const std::uint32_t index : std::exchange(session.exchanges, {})) {
    exchanges_[index].client_gone = true;
    cancel_waiting(index, false);
  }
}

void Gateway::forget(Sessions::iterator client) {
  drop_requests(client->second);
  failsafe_.client_gone(client->first);
  timers_.cancel(client->first, client->second.timer_armed_at);
  const ClientInfo info = client->second.info();
  --listener_clients_[static_cast<std::size_t>(info.listener)];
  const auto source = sources_.find(info.address);
  if (--source->second.connections == 0) {
    free_sources_.push_back(source->second.id);
    sources_.erase(source);
  }
  sessions_.erase(client);
}

// Connections from one address are one source: they share its turns. Source 0 is the gateway.
void Gateway::add_connection(const routing::ClientAddress& address) {
  const auto known = sources_.find(address);
  if (known != sources_.end()) {
    ++known->second.connections;
    return;
  }
  bus::FairnessKey id{static_cast<std::uint32_t>(sources_.size() + 1)};
  if (!free_sources_.empty()) {
    id = free_sources_.back();
    free_sources_.pop_back();
  }
  sources_.emplace(address, Source{id, 1, weight_of(address)});
}

unsigned Gateway::weight_of(const routing::ClientAddress& address) const {
  const auto& weights = settings().weights;
  const auto fitting = std::ranges::find_if(
      weights, [&](const ClientWeight& it) { return it.network.contains(address); });
  return fitting == weights.end() ? 1 : fitting->weight;
}

}  // namespace mbgate::gateway
