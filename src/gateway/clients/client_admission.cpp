// SPDX-License-Identifier: Apache-2.0

#include "gateway/clients/client_admission.hpp"

#include <algorithm>
#include <map>
#include <tuple>
#include <utility>
#include <vector>

namespace mbgate::gateway {

namespace {

// Who never asked, then who has nothing to do, for longest; then who connected first.
bool goes_before(const ClientSession* one, const ClientSession* other) {
  const auto place = [](const ClientSession& it) {
    return std::tuple(it.has_asked, !it.is_at_rest(),
                      it.is_at_rest() ? it.last_activity : Instant::min(), it.id());
  };
  return place(*one) < place(*other);
}

ClientSession* first_to_go(const std::vector<ClientSession*>& candidates) {
  const auto first = std::ranges::min_element(candidates, goes_before);
  return first == candidates.end() ? nullptr : *first;
}

std::vector<ClientSession*> displaceable(Sessions& sessions, ListenerId listener) {
  std::vector<ClientSession*> all;
  sessions.for_each([&](ClientSession& session) {
    if (session.info().listener == listener &&
        !session.listener().keep.contains(session.info().address, session.info().role)) {
      all.push_back(&session);
    }
  });
  return all;
}

// Makes room for another connection of this client, because the client has as many as it may. One
// that waits for an answer stays.
ClientSession* to_replace(Sessions& sessions, ListenerId listener, const ClientKey& client) {
  auto own = displaceable(sessions, listener);
  std::erase_if(own,
                [&](const ClientSession* it) { return it->key() != client || !it->is_at_rest(); });
  return first_to_go(own);
}

// Makes room because the listener is full: one of the client that has most of them, the newcomer
// counted. Where each client has one, only one that has never asked; nullptr: none.
ClientSession* to_displace(Sessions& sessions, ListenerId listener, const ClientKey& newcomer) {
  auto all = displaceable(sessions, listener);
  std::map<ClientKey, std::size_t> counts{{newcomer, 1}};
  for (const ClientSession* session : all) {
    ++counts[session->key()];
  }
  std::size_t most = 1;
  for (const auto& [client, connections] : counts) {
    most = std::max(most, connections);
  }
  const bool is_newcomer = most > 1 && counts[newcomer] == most;
  std::erase_if(all, [&](const ClientSession* it) {
    const bool is_loser = is_newcomer ? it->key() == newcomer : counts[it->key()] == most;
    return !is_loser || (most == 1 && it->has_asked);
  });
  return first_to_go(all);
}

}  // namespace

void ClientAdmission::connected(ClientId client, const ClientInfo& info, Phase phase, Instant now) {
  if (!admit(info, phase, now)) {
    actions_.push(Close{client});
    return;
  }
  if (const ClientSession* session = sessions_.add(client, info, now)) {
    limits_.came(*session, now);
    notice_login(info, now);
  }
}

void ClientAdmission::notice_login(const ClientInfo& info, Instant now) {
  if (info.role.kind != routing::ClientRole::Kind::none) {
    if (const auto left_out = logins_.note(info, now)) {
      actions_.push(Report{ClientLoggedIn{asker_of(info), *left_out}});
    }
  }
}

bool ClientAdmission::admit(const ClientInfo& info, Phase phase, Instant now) {
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

std::optional<RefusalReason> ClientAdmission::objection(const ClientInfo& info, Phase phase,
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
std::optional<RefusalReason> ClientAdmission::make_room(ClientSession* displaced,
                                                        RefusalReason limit, Instant now) {
  if (displaced == nullptr) {
    return limit;
  }
  const ClientInfo info = displaced->info();
  actions_.push(Report{ClientDisplaced{{info.listener, info.address}, limit}});
  sessions_.counters(info.listener).note_displaced(limit);
  close(*displaced, now);
  return std::nullopt;
}

void ClientAdmission::refuse(const ClientInfo& info, RefusalReason reason) {
  actions_.push(Report{ClientRefused{{info.listener, info.address}, reason}});
  sessions_.counters(info.listener).note_refused(reason);
}

bool ClientAdmission::may_ask(const ClientSession& session, Instant now) {
  if (limits_.may_ask(session, now)) {
    return true;
  }
  ++sessions_.counters(session.info().listener).over_rate;
  if (limits_.may_be_reported(session, now)) {
    actions_.push(Report{ClientOverRate{{session.info().listener, session.info().address}}});
  }
  return false;
}

void ClientAdmission::drop_requests(ClientSession& session) {
  for (const std::uint32_t exchange : std::exchange(session.exchanges, {})) {
    exchanges_[exchange].client_gone = true;
    exchanges_.cancel(exchange);
  }
}

void ClientAdmission::close(ClientSession& session, Instant now) {
  actions_.push(Close{session.id()});
  forget(session, now);
}

void ClientAdmission::forget(ClientSession& session, Instant now) {
  drop_requests(session);
  failsafe_.client_gone(session.id(), now);
  limits_.left(session);
  sessions_.close(session);
}

}  // namespace mbgate::gateway
