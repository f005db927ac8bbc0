// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/clients.hpp"

#include <utility>

namespace mbgate::gateway {

Clients::Clients(const SettingsHistory& settings, BusSet& buses, Exchanges& exchanges,
                 WriteRules& rules, FailsafeWrites& failsafe, TraceBook& trace,
                 ActionQueue& actions, Instant now)
    : settings_(settings),
      exchanges_(exchanges),
      rules_(rules),
      failsafe_(failsafe),
      actions_(actions),
      sessions_(settings.settings()),
      intake_(settings, rules, actions),
      requests_(settings, buses, exchanges, rules, failsafe, sessions_, intake_, trace, actions,
                now) {}

void Clients::connected(ClientId client, const ClientInfo& info, Instant now) {
  if (!admit(info, now)) {
    actions_.push(Close{client});
    return;
  }
  if (const ClientSession* session = sessions_.add(client, info, now)) {
    limits_.came(info, session->listener(), now);
    failsafe_.client_came(*session);
  }
}

bool Clients::admit(const ClientInfo& info, Instant now) {
  const ListenerSettings& listener = settings_.settings().listener(info.listener);
  if (listener.is_gone && intake_.phase() == Phase::running) {
    return false;  // it was let in before a reload, and told after it
  }
  auto reason = objection(info, now);
  if (!reason && limits_.is_full(info, listener) && !make_room(info, &info.address)) {
    reason = RefusalReason::address_full;
  }
  if (!reason && sessions_.is_full(info.listener) && !make_room(info, nullptr)) {
    reason = RefusalReason::full;
  }
  if (reason) {
    refuse(info, *reason);
  }
  return !reason;
}

std::optional<RefusalReason> Clients::objection(const ClientInfo& info, Instant now) const {
  const ListenerSettings& listener = settings_.settings().listener(info.listener);
  if (intake_.phase() != Phase::running) {
    return RefusalReason::stopping;
  }
  if (!listener.allow.empty() && !routing::contains(listener.allow, info.address)) {
    return RefusalReason::not_allowed;
  }
  if (!may_connect(settings_.settings(), info)) {
    return RefusalReason::no_rule;
  }
  return limits_.comes_too_often(info, listener, now) ? std::optional(RefusalReason::too_often)
                                                      : std::nullopt;
}

// Of the same address, or of any. A client that comes back after its line was cut finds its old
// connections in the way.
bool Clients::make_room(const ClientInfo& info, const routing::ClientAddress* address) {
  ClientSession* idlest = sessions_.idlest(info.listener, address);
  if (idlest == nullptr) {
    return false;
  }
  actions_.push(Report{ClientDisplaced{info.listener, idlest->info().address}});
  ++sessions_.counters(info.listener).displaced;
  close(*idlest);
  return true;
}

void Clients::refuse(const ClientInfo& info, RefusalReason reason) {
  actions_.push(Report{ClientRefused{info.listener, info.address, reason}});
  sessions_.counters(info.listener).note_refused(reason);
}

void Clients::received(ClientId client, modbus::Bytes bytes, std::size_t unread, Instant now) {
  ClientSession* session = sessions_.find(client);
  if (session == nullptr) {
    return;
  }
  if (!bytes.empty()) {
    session->last_activity = now;
  }
  if (!session->has_asked) {
    intake_.notice_rtu(*session, bytes);  // some RTU frames can be read as MBAP
  }
  session->input.append(bytes, session->arrival_of(bytes.size(), unread, now));
  sessions_.wake(*session);
}

void Clients::sent(ClientId client, Instant now) {
  if (ClientSession* session = sessions_.find(client)) {
    session->answers.confirm_sent();
    session->last_activity = now;
    sessions_.wake(*session);
  }
}

void Clients::half_closed(ClientId client) {
  ClientSession* session = sessions_.find(client);
  if (session == nullptr) {
    return;
  }
  session->half_close();
  for (const std::uint32_t exchange : session->exchanges) {
    if (!exchanges_[exchange].plan->is_read()) {
      exchanges_.cancel(exchange);
    }
  }
  sessions_.wake(*session);
}

void Clients::disconnected(ClientId client, Instant now) {
  if (ClientSession* session = sessions_.find(client)) {
    leave(*session, now);
    forget(*session);
  }
}

void Clients::stalled(Instant since) {
  sessions_.for_each([since](ClientSession& session) { session.stall(since); });
}

void Clients::handle_deadline(Instant now) {
  while (ClientSession* session = sessions_.take_due(now)) {
    switch (session->overdue(now)) {
      case ClientSession::Overdue::within_request:
        actions_.push(
            Report{ClientFrameTimedOut{session->info().listener, session->info().address}});
        close(*session);
        break;
      case ClientSession::Overdue::idle: close(*session); break;
      case ClientSession::Overdue::nothing:
        session->end_hold(now);
        if (session->has_turn) {
          sessions_.wake(*session);
        }
        sessions_.look_at(*session, session->next_look(now));
        break;
    }
  }
}

void Clients::set_phase(Phase phase) {
  intake_.set_phase(phase);
  sessions_.for_each([this](const ClientSession& session) { sessions_.wake(session); });
}

bool Clients::serve_one(Instant now) {
  ClientSession* session = sessions_.take_ready();
  if (session != nullptr) {
    serve(*session, now);
  }
  return session != nullptr;
}

void Clients::serve(ClientSession& session, Instant now) {
  while (!session.input.empty() && may_take(session, now)) {
    const auto next = intake_.next(session, now);
    if (next.request != nullptr) {
      session.has_turn = false;
      requests_.accept(session, *next.request, now);
    } else if (next.stop) {
      requests_.pass_early(session, *next.stop);
    } else if (next.framing_lost) {
      close(session);
      return;
    } else {
      break;
    }
  }
  if (session.is_held_up()) {
    take_early_stops(session, now);
  }
  const bool may_go_on = session.held_until && !session.is_full();
  if (may_go_on && session.ahead.goes_on(session.position())) {
    sessions_.wake(session);  // as far as to the last of these stops
  }
  failsafe_.client_waits(session.id(), !session.exchanges.empty() || session.held_until, now);
  if (session.is_finished()) {
    close(session);
    return;
  }
  if (const auto reading = session.update_reading(now)) {
    if (*reading == ClientSession::Reading::pause) {
      actions_.push(Pause{session.id()});
    } else {
      actions_.push(Resume{session.id()});
    }
  }
  session.note_partial(now);
  sessions_.look_at(session, session.next_look(now));
}

bool Clients::may_take(ClientSession& session, Instant now) {
  if (intake_.phase() != Phase::running) {
    session.held_until.reset();
    return true;
  }
  const bool was_held = session.held_until.has_value();
  const bool may_ask = limits_.may_ask(session, now);
  if (session.held_until && !was_held) {
    ++sessions_.counters(session.info().listener).held_up;
    if (limits_.is_news(session.info(), now)) {
      actions_.push(Report{ClientHeldUp{session.info().listener, session.info().address}});
    }
  }
  return may_ask;
}

void Clients::take_early_stops(ClientSession& session, Instant now) {
  intake_.begin_early(session);
  while (Request* stop = intake_.next_early(session, now)) {
    requests_.accept(session, *stop, now);
  }
}

// The stops that it has sent are still taken.
void Clients::leave(ClientSession& session, Instant now) {
  session.is_leaving = true;
  drop_requests(session);  // before a stop sets the bus going
  take_early_stops(session, now);
}

// Nobody is told what becomes of its requests.
void Clients::drop_requests(ClientSession& session) {
  for (const std::uint32_t exchange : std::exchange(session.exchanges, {})) {
    exchanges_[exchange].client_gone = true;
    exchanges_.cancel(exchange);
  }
}

void Clients::close(ClientSession& session) {
  actions_.push(Close{session.id()});
  forget(session);
}

void Clients::forget(ClientSession& session) {
  drop_requests(session);
  failsafe_.client_gone(session.id());
  rules_.client_gone(session.id());
  limits_.left(session);
  sessions_.close(session);
}

void Clients::close_unwanted(const Settings& next, Instant now) {
  sessions_.for_each([&](ClientSession& session) {
    const ListenerId number = session.info().listener;
    const routing::ClientAddress& address = session.info().address;
    const ListenerSettings& listener = next.listener(number);
    const bool allowed = listener.allow.empty() || routing::contains(listener.allow, address);
    // What a client was without TLS it is not with it, and the other way round.
    const bool had_tls = session.info().role.kind != routing::ClientRole::Kind::none;
    const bool is_of_another_kind = had_tls != listener.tls.has_value();
    if (!listener.is_gone && !is_of_another_kind && allowed && may_connect(next, session.info())) {
      return;
    }
    if (!listener.is_gone && !is_of_another_kind) {
      const auto reason = allowed ? RefusalReason::no_rule : RefusalReason::not_allowed;
      actions_.push(Report{ClientRefused{number, address, reason}});
    }
    leave(session, now);
    close(session);
  });
}

void Clients::adopt(const SettingsSnapshot& before, Instant now) {
  sessions_.adopt(settings_.settings());
  intake_.adopt(before, now);
}

}  // namespace mbgate::gateway
