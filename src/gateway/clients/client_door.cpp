// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/client_door.hpp"

#include <utility>

#include "gateway/clients/room.hpp"

namespace mbgate::gateway {

void ClientDoor::connected(ClientId client, const ClientInfo& info, Phase phase, Instant now) {
  if (!admit(info, phase, now)) {
    actions_.push(Close{client});
    return;
  }
  if (const ClientSession* session = sessions_.add(client, info, now)) {
    limits_.came(*session, now);
    notice_login(info, now);
  }
}

void ClientDoor::notice_login(const ClientInfo& info, Instant now) {
  if (info.role.kind != routing::ClientRole::Kind::none) {
    if (const auto left_out = logins_.note(info, now)) {
      actions_.push(Report{ClientLoggedIn{asker_of(info), *left_out}});
    }
  }
}

bool ClientDoor::admit(const ClientInfo& info, Phase phase, Instant now) {
  const ListenerSettings& listener = settings_.settings().listener(info.listener);
  if (listener.is_gone && phase == Phase::running) {
    return false;  // it was let in before a reload, and told after it
  }
  auto reason = objection(info, phase, now);
  if (!reason && limits_.is_full(info, listener)) {
    reason = make_room(to_replace(sessions_, info.listener, key_of(info, listener)),
                       RefusalReason::address_full, now);
  }
  if (!reason && sessions_.is_full(info.listener)) {
    reason = make_room(to_displace(sessions_, info.listener, key_of(info, listener)),
                       RefusalReason::full, now);
  }
  if (reason) {
    refuse(info, *reason);
  }
  return !reason;
}

std::optional<RefusalReason> ClientDoor::objection(const ClientInfo& info, Phase phase,
                                                   Instant now) const {
  const ListenerSettings& listener = settings_.settings().listener(info.listener);
  if (phase != Phase::running) {
    return RefusalReason::stopping;
  }
  if (!routing::lets_in(listener.allow, info.address)) {
    return RefusalReason::not_allowed;
  }
  if (!may_connect(settings_.settings(), info)) {
    return RefusalReason::no_rule;
  }
  return limits_.comes_too_often(info, listener, now) ? std::optional(RefusalReason::too_often)
                                                      : std::nullopt;
}

// A client that comes back after its line was cut finds its old connections in the way.
std::optional<RefusalReason> ClientDoor::make_room(ClientSession* displaced, RefusalReason limit,
                                                   Instant now) {
  if (displaced == nullptr) {
    return limit;
  }
  const ClientInfo info = displaced->info();
  actions_.push(Report{ClientDisplaced{info.listener, info.address, limit}});
  sessions_.counters(info.listener).note_displaced(limit);
  close(*displaced, now);
  return std::nullopt;
}

void ClientDoor::refuse(const ClientInfo& info, RefusalReason reason) {
  actions_.push(Report{ClientRefused{info.listener, info.address, reason}});
  sessions_.counters(info.listener).note_refused(reason);
}

bool ClientDoor::may_ask(const ClientSession& session, Instant now) {
  if (limits_.may_ask(session, now)) {
    return true;
  }
  ++sessions_.counters(session.info().listener).over_rate;
  if (limits_.is_to_be_told(session, now)) {
    actions_.push(Report{ClientOverRate{session.info().listener, session.info().address}});
  }
  return false;
}

void ClientDoor::drop_requests(ClientSession& session) {
  for (const std::uint32_t exchange : std::exchange(session.exchanges, {})) {
    exchanges_[exchange].client_gone = true;
    exchanges_.cancel(exchange);
  }
}

void ClientDoor::close(ClientSession& session, Instant now) {
  actions_.push(Close{session.id()});
  forget(session, now);
}

void ClientDoor::forget(ClientSession& session, Instant now) {
  drop_requests(session);
  failsafe_.client_gone(session.id(), now);
  limits_.left(session);
  sessions_.close(session);
}

}  // namespace mbgate::gateway
