// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/clients.hpp"

#include <algorithm>
#include <utility>

#include "gateway/limits.hpp"

namespace mbgate::gateway {
namespace {

std::optional<RefusalReason> objection(const Settings& settings, const ClientInfo& info) {
  if (!routing::lets_in(settings.listener(info.listener).allow, info.address)) {
    return RefusalReason::not_allowed;
  }
  return may_connect(settings, info) ? std::nullopt : std::optional(RefusalReason::no_rule);
}

}  // namespace

Clients::Clients(const SettingsHistory& settings, BusSet& buses, Exchanges& exchanges,
                 WriteRules& rules, FailsafeWrites& failsafe, TraceBook& trace,
                 ActionQueue& actions, Instant now)
    : settings_(settings),
      exchanges_(exchanges),
      failsafe_(failsafe),
      actions_(actions),
      sessions_(settings.settings()),
      intake_(settings, rules, actions),
      requests_(settings, buses, exchanges, rules, failsafe, sessions_, intake_, trace, actions,
                now) {}

void Clients::handle(const ClientConnected& input, Instant now) {
  if (!admit(input.info, now)) {
    actions_.push(Close{input.client});
    return;
  }
  const ClientSession* session = sessions_.add(input.client, input.info, now);
  if (session == nullptr) {
    return;
  }
  limits_.came(*session, now);
  if (input.info.role.kind != routing::ClientRole::Kind::none) {
    if (const auto left_out = logins_.note(input.info, now)) {
      actions_.push(Report{ClientLoggedIn{asker_of(input.info), *left_out}});
    }
  }
}

bool Clients::admit(const ClientInfo& info, Instant now) {
  const bool is_running = intake_.phase() == Phase::running;
  const ListenerSettings& listener = settings_.settings().listener(info.listener);
  if (listener.is_gone && is_running) {
    return false;  // it was let in before a reload, and told after it
  }
  auto reason = is_running ? objection(settings_.settings(), info) : RefusalReason::stopping;
  if (!reason && limits_.comes_too_often(info, listener, now)) {
    reason = RefusalReason::too_often;
  }
  if (!reason && limits_.is_full(info, listener)) {
    reason = make_room(to_replace(sessions_, info.listener, key_of(info, listener)),
                       RefusalReason::address_full, now);
  }
  if (!reason && sessions_.is_full(info.listener)) {
    reason = make_room(to_displace(sessions_, info.listener, key_of(info, listener)),
                       RefusalReason::full, now);
  }
  if (reason) {
    actions_.push(Report{ClientRefused{asker_of(info), *reason}});
    sessions_.counters(info.listener).note_refused(*reason);
  }
  return !reason;
}

// A client that comes back after its line was cut finds its old connections in the way.
std::optional<RefusalReason> Clients::make_room(ClientSession* displaced, RefusalReason limit,
                                                Instant now) {
  if (displaced == nullptr) {
    return limit;
  }
  const ClientInfo& info = displaced->info();
  actions_.push(Report{ClientDisplaced{asker_of(info), limit}});
  sessions_.counters(info.listener).note_displaced(limit);
  close(*displaced, now);
  return std::nullopt;
}

void Clients::handle(const ClientBytes& input, Instant now) {
  ClientSession* session = sessions_.find(input.client);
  if (session == nullptr) {
    return;
  }
  if (!session->has_asked) {
    intake_.notice_rtu(*session, input.bytes);  // some RTU frames can be read as MBAP
  }
  const Instant arrival = session->arrival_of(input.unread, now);
  if (!input.bytes.empty()) {
    session->last_activity = now;
    session->input.append(input.bytes, arrival, now);
  }
  sessions_.wake(*session);
}

void Clients::handle(const ClientSent& input, Instant now) {
  if (ClientSession* session = sessions_.find(input.client)) {
    session->answers.confirm_sent();
    session->last_activity = now;
    sessions_.wake(*session);
  }
}

void Clients::handle(const ClientHalfClosed& input, Instant /*now*/) {
  ClientSession* session = sessions_.find(input.client);
  if (session == nullptr) {
    return;
  }
  session->half_close();
  for (const std::uint32_t exchange : session->exchanges) {
    if (!exchanges_[exchange].plan->is_read()) {
      exchanges_.take_back(exchange);
    }
  }
  sessions_.wake(*session);
}

void Clients::handle(const ClientDisconnected& input, Instant now) {
  if (ClientSession* session = sessions_.find(input.client)) {
    if (!input.bytes.empty()) {
      session->input.append(input.bytes, now, now);
    }
    leave(*session, now);
    forget(*session, now);
  }
}

void Clients::stalled(Instant since) {
  for (ClientSession& session : sessions_.open()) {
    session.stall(since);
  }
}

void Clients::handle_deadline(Instant now) {
  while (ClientSession* session = sessions_.take_due(now)) {
    requests_.end_overdue(*session, now);
    switch (session->overdue(now)) {
      case ClientSession::Overdue::within_request:
        actions_.push(Report{ClientFrameTimedOut{asker_of(session->info())}});
        close(*session, now);
        break;
      case ClientSession::Overdue::idle: close(*session, now); break;
      case ClientSession::Overdue::nothing: set_timer(*session, now); break;
    }
  }
}

void Clients::set_phase(Phase phase) {
  intake_.set_phase(phase);
  for (ClientSession& session : sessions_.open()) {
    for (const std::uint32_t held : session.held) {
      exchanges_.cancel(held);  // what no bus has yet
    }
    sessions_.wake(session);
  }
}

bool Clients::serve_one(Instant now) {
  ClientSession* ready = sessions_.take_ready();
  if (ready == nullptr) {
    return false;
  }
  ClientSession& session = *ready;
  Intake::Front front = intake_.front(session);
  for (; front.frame; front = intake_.front(session)) {
    Request& request = intake_.take(session, *front.frame, now);
    const bool is_taken = request.is_stop || intake_.phase() != Phase::running ||
                          (may_ask(session, now) && exchanges_.planned() < kTransactionsOfAll &&
                           exchanges_.planned(session.exchanges) < kTransactionsOfOne);
    if (!is_taken && !request.refused) {
      request.for_gateway = false;
      request.refused = modbus::ExceptionCode::server_device_busy;
    }
    requests_.accept(session, request, now);
  }
  if (front.framing_lost || session.is_finished()) {
    close(session, now);
    return true;
  }
  if (const auto reading = session.update_reading(now)) {
    if (*reading == ClientSession::Reading::pause) {
      actions_.push(Pause{session.id()});
    } else {
      actions_.push(Resume{session.id()});
    }
  }
  session.note_partial(now);
  set_timer(session, now);
  return true;
}

bool Clients::may_ask(const ClientSession& session, Instant now) {
  if (limits_.may_ask(session, now)) {
    return true;
  }
  ++sessions_.counters(session.info().listener).over_rate;
  if (over_rate_.note(session.info(), now)) {
    actions_.push(Report{ClientOverRate{asker_of(session.info())}});
  }
  return false;
}

void Clients::set_timer(ClientSession& session, Instant now) {
  const auto look = session.next_look(now);
  sessions_.look_at(session, bus::earlier(look, requests_.first_deadline(session)));
}

// The stops that it has sent are still taken.
void Clients::leave(ClientSession& session, Instant now) {
  session.is_leaving = true;
  drop_requests(session, now);  // before a stop sets the bus going
  while (Request* stop = intake_.take_stop(session, now)) {
    requests_.accept(session, *stop, now);
  }
}

void Clients::drop_requests(ClientSession& session, Instant now) {
  RecentFailures& recent = sessions_.counters(session.info().listener).recent;
  for (const std::uint32_t exchange : std::exchange(session.exchanges, {})) {
    exchanges_[exchange].client_gone = true;
    recent.note_unanswered(now);
    exchanges_.cancel(exchange);
  }
}

void Clients::close(ClientSession& session, Instant now) {
  actions_.push(Close{session.id()});
  forget(session, now);
}

void Clients::forget(ClientSession& session, Instant now) {
  drop_requests(session, now);
  failsafe_.client_gone(session.id(), now);
  limits_.left(session);
  sessions_.close(session);
}

void Clients::close_unwanted(const Settings& next, Instant now) {
  for (ClientSession& session : sessions_.open()) {
    const ListenerSettings& listener = next.listener(session.info().listener);
    // What a client was without TLS it is not with it, and the other way round.
    const bool had_tls = session.info().role.kind != routing::ClientRole::Kind::none;
    const bool has_place = !listener.is_gone && had_tls == listener.tls.has_value();
    const auto reason = has_place ? objection(next, session.info()) : std::nullopt;
    if (reason) {
      actions_.push(Report{ClientRefused{asker_of(session.info()), *reason}});
    }
    if (reason || !has_place) {
      leave(session, now);
      close(session, now);
    }
  }
}

void Clients::adopt(const SettingsSnapshot& before, Instant now) {
  sessions_.adopt(settings_.settings(), now);
  intake_.adopt(before, now);
  for (const ClientSession& session : sessions_.open()) {
    requests_.end_unwanted(session, before, now);
  }
}

}  // namespace mbgate::gateway
