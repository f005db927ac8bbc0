// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/clients.hpp"

namespace mbgate::gateway {

Clients::Clients(const SettingsHistory& settings, BusSet& buses, Exchanges& exchanges,
                 WriteRules& rules, FailsafeWrites& failsafe, TraceBook& trace,
                 ActionQueue& actions, Instant now)
    : settings_(settings),
      exchanges_(exchanges),
      actions_(actions),
      sessions_(settings.settings()),
      intake_(settings, rules, actions),
      admission_(settings, exchanges, failsafe, sessions_, actions),
      requests_(settings, buses, exchanges, rules, failsafe, sessions_, intake_, trace, actions,
                now) {}

void Clients::handle(const ClientConnected& input, Instant now) {
  admission_.connected(input.client, input.info, intake_.phase(), now);
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
    admission_.forget(*session, now);
  }
}

void Clients::stalled(Instant since) {
  sessions_.for_each([since](ClientSession& session) { session.stall(since); });
}

void Clients::handle_deadline(Instant now) {
  while (ClientSession* session = sessions_.take_due(now)) {
    requests_.end_overdue(*session, now);
    switch (session->overdue(now)) {
      case ClientSession::Overdue::within_request:
        actions_.push(
            Report{ClientFrameTimedOut{{session->info().listener, session->info().address}}});
        admission_.close(*session, now);
        break;
      case ClientSession::Overdue::idle: admission_.close(*session, now); break;
      case ClientSession::Overdue::nothing: set_timer(*session, now); break;
    }
  }
}

void Clients::set_phase(Phase phase) {
  intake_.set_phase(phase);
  sessions_.for_each([this](const ClientSession& session) {
    for (const std::uint32_t held : session.held) {
      exchanges_.cancel(held);  // what no bus has yet
    }
    sessions_.wake(session);
  });
}

bool Clients::serve_one(Instant now) {
  ClientSession* session = sessions_.take_ready();
  if (session != nullptr) {
    serve(*session, now);
  }
  return session != nullptr;
}

void Clients::serve(ClientSession& session, Instant now) {
  Intake::Front front = intake_.front(session);
  for (; front.frame; front = intake_.front(session)) {
    Request& request = intake_.take(session, *front.frame, now);
    const bool may_ask =
        request.is_stop || intake_.phase() != Phase::running ||
        (admission_.may_ask(session, now) && exchanges_.planned() < kTransactionsOfAll &&
         exchanges_.planned(session.exchanges) < kTransactionsOfOne);
    if (!may_ask && !request.refused) {
      request.for_gateway = false;
      request.refused = modbus::ExceptionCode::server_device_busy;
    }
    requests_.accept(session, request, now);
  }
  if (front.framing_lost || session.is_finished()) {
    admission_.close(session, now);
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
  set_timer(session, now);
}

void Clients::set_timer(ClientSession& session, Instant now) {
  const auto look = session.next_look(now);
  sessions_.look_at(session, bus::earlier(look, requests_.first_deadline(session)));
}

// The stops that it has sent are still taken.
void Clients::leave(ClientSession& session, Instant now) {
  session.is_leaving = true;
  admission_.drop_requests(session);  // before a stop sets the bus going
  while (Request* stop = intake_.take_stop(session, now)) {
    requests_.accept(session, *stop, now);
  }
}

void Clients::close_unwanted(const Settings& next, Instant now) {
  sessions_.for_each([&](ClientSession& session) {
    const ListenerId number = session.info().listener;
    const routing::ClientAddress& address = session.info().address;
    const ListenerSettings& listener = next.listener(number);
    const bool allowed = routing::lets_in(listener.allow, address);
    // What a client was without TLS it is not with it, and the other way round.
    const bool had_tls = session.info().role.kind != routing::ClientRole::Kind::none;
    const bool is_of_another_kind = had_tls != listener.tls.has_value();
    if (!listener.is_gone && !is_of_another_kind && allowed && may_connect(next, session.info())) {
      return;
    }
    if (!listener.is_gone && !is_of_another_kind) {
      const auto reason = allowed ? RefusalReason::no_rule : RefusalReason::not_allowed;
      actions_.push(Report{ClientRefused{{number, address}, reason}});
    }
    leave(session, now);
    admission_.close(session, now);
  });
}

void Clients::adopt(const SettingsSnapshot& before, Instant now) {
  sessions_.adopt(settings_.settings(), now);
  intake_.adopt(before, now);
  sessions_.for_each([&](ClientSession& session) {
    requests_.end_withdrawn(session, now);
    requests_.end_outdated(session, before);
  });
}

}  // namespace mbgate::gateway
