// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/requests.hpp"

#include <algorithm>
#include <utility>

#include "base/assert.hpp"
#include "gateway/settings/settings_snapshot.hpp"
#include "routing/device_plan.hpp"

namespace mbgate::gateway {
namespace {

ByteString bytes_of(const modbus::MbapAdu& adu) {
  const modbus::MbapBytes bytes = modbus::encode(adu);
  return {bytes.begin(), bytes.end()};
}

std::uint8_t code_of(const modbus::Pdu& exception) { return exception.bytes()[1]; }

/// The answer to a client, once every part has ended; nothing if none is to be given.
std::optional<modbus::MbapAdu> adu_of(const Exchange& exchange) {
  const auto pdu = exchange.result();
  return pdu ? std::optional(modbus::MbapAdu{exchange.header, *pdu}) : std::nullopt;
}

/// Where all of a write goes; nothing: to several.
std::optional<WriteAccepted::Target> target_of(const routing::Plan& plan) {
  std::optional<WriteAccepted::Target> found;
  for (const auto& part : plan.transactions()) {
    const WriteAccepted::Target target{part.bus, part.address};
    if (found && *found != target) {
      return std::nullopt;
    }
    found = target;
  }
  return found;
}

AskedTrace trace_of(const ClientSession& session, const Request& request) {
  return {session.id(), session.info().address, session.listener().name, request.arrival,
          bytes_of(request.adu)};
}

// A client that has given up may take an answer for that to its next request. `arrival`: of the
// request.
DueAnswers::Answer answer_of(const ClientSession& session, const modbus::MbapAdu& adu,
                             Instant arrival, bool is_stops) {
  const Duration give_up = session.listener().give_up;
  const Instant until = give_up > Duration{0} ? arrival + give_up : Instant::max();
  return {modbus::encode(adu), until, is_stops};
}

}  // namespace

void Requests::accept(ClientSession& session, Request& request, Instant now) {
  if (request.plan) {
    const bool writes = !request.refused && !request.is_stop && !request.plan->is_read();
    failsafe_.client_asked(session, *request.plan, writes, now);
  }
  ++session.requests;
  ListenerCounters& counters = sessions_.counters(session.info().listener);
  counters.note_request();
  replace_unanswered(session);
  if (request.for_gateway) {
    answer_at_once(session, request, answer_of_gateway(session, request, now), now);
  } else if (request.refused) {
    const auto answer = modbus::Pdu::exception(request.adu.pdu.function(), *request.refused);
    ++session.refused;
    counters.note_refused(modbus::is_read(request.adu.pdu.bytes()), code_of(answer), now);
    answer_at_once(session, request, answer, now);
  } else {
    begin(session, request, now);
  }
}

void Requests::answer_at_once(ClientSession& session, const Request& request,
                              const modbus::Pdu& answer, Instant now) {
  const modbus::MbapAdu adu{request.adu.header, answer};
  if (trace_.is_on()) {
    AskedTrace asked = trace_of(session, request);
    asked.answer = bytes_of(adu);
    asked.answered_at = now;
    trace_.refused(std::move(asked));
  }
  send(session, session.answers.open(),
       answer_of(session, adu, request.asked_at(), request.is_stop), now);
}

void Requests::begin(ClientSession& session, Request& request, Instant now) {
  const WriteOrigin origin = request.origin(session);
  // What the status unit is asked is not among these: only 08/0A changes anything there, and that
  // is always told.
  if (settings_.settings().audit && !request.plan->is_read()) {
    actions_.push(Report{WriteAccepted{asked_of(session.info(), request.adu), request.is_stop,
                                       target_of(*request.plan)}});
  }
  say_left_out(session, request);
  const std::uint32_t index = exchanges_.open(std::move(request.plan));
  Exchange& exchange = exchanges_[index];
  exchange.client = session.id();
  exchange.listener = session.info().listener;
  exchange.address = session.info().address;
  exchange.header = request.adu.header;
  exchange.route = request.route;
  if (trace_.is_on()) {
    trace_.asked(index, trace_of(session, request), *exchange.plan);
  }
  exchange.client_gone = session.is_leaving;
  if (!session.is_leaving) {
    session.exchanges.push_back(index);
    exchange.answer = session.answers.open();
  }
  exchange.arrival = request.asked_at();
  exchange.deadline = exchanges_.deadline_of(exchange);
  exchange.is_stop = request.is_stop;
  exchange.sequence = rules_.note_accepted(*exchange.plan, origin, now);
  if (request.is_stop) {
    exchanges_.start(index, *session.turns, now);
    return;
  }
  exchange.is_held = true;  // beyond `pipeline`, in their order
  session.held.push_back(index);
  start_held(session, now);
}

void Requests::say_left_out(const ClientSession& session, const Request& request) {
  if (!request.route->is_broadcast()) {
    return;
  }
  BroadcastLeavesOut event{asked_of(session.info(), request.adu), request.is_stop};
  for (const drive::Device* device :
       routing::not_addressed(*request.route, *request.plan, request.is_stop)) {
    event.devices += (event.devices.empty() ? "" : ", ") + device->name;
  }
  if (!event.devices.empty()) {
    actions_.push(Report{std::move(event)});
  }
}

// A dumb session asks again on the same connection once it has given up (`one_at_a_time`). It takes
// an answer to what it asked before for that to its next request.
void Requests::replace_unanswered(ClientSession& session) {
  if (!session.listener().one_at_a_time) {
    return;
  }
  for (const std::uint32_t index : session.exchanges) {
    if (Exchange& unanswered = exchanges_[index]; !unanswered.is_stop) {
      unanswered.is_replaced = true;
      exchanges_.take_back(index);
    }
  }
  session.answers.drop_waiting();
}

void Requests::start_held(ClientSession& session, Instant now) {
  while (!session.held.empty() && session.has_room_on_buses()) {
    const std::uint32_t index = session.held.front();
    session.held.erase(session.held.begin());
    Exchange& exchange = exchanges_[index];
    if (!exchange.is_held) {
      continue;  // it was refused meanwhile, and completes
    }
    if (rules_.was_stopped(*exchange.plan, exchange.sequence)) {
      exchanges_.refuse(index);
    } else {
      exchanges_.start(index, *session.turns, now);
    }
  }
}

std::optional<Instant> Requests::first_deadline(const ClientSession& session) const {
  std::optional<Instant> first;
  for (const std::uint32_t held : session.held) {
    if (exchanges_[held].is_held) {
      first = bus::earlier(first, exchanges_[held].deadline);
    }
  }
  return first;
}

void Requests::end_overdue(const ClientSession& session, Instant now) {
  for (const std::uint32_t held : session.held) {
    if (exchanges_[held].is_held && now >= exchanges_[held].deadline) {
      exchanges_.refuse(held);
    }
  }
}

// Where its unit leads nowhere any more, the request means something else: Exchanges ends it.
bool Requests::is_withdrawn(const ClientSession& session, const Exchange& exchange,
                            Instant now) const {
  const SettingsSnapshot& settings = settings_.in_force();
  const std::uint8_t unit = exchange.header.unit;
  const auto* route = settings.routes.find(exchange.listener, unit);
  if (route == nullptr) {
    return false;
  }
  const modbus::Pdu& asked = exchange.plan->asked();
  const auto plan = routing::Plan::make(*route, unit, session.rights(), asked);
  if (!plan || !verdict_on(settings, session.info(), unit, asked, &*plan).permitted) {
    return true;
  }
  const WriteOrigin origin{session.id(), session.info(), session.key(), now};
  const auto objection = rules_.objection(*plan, origin, now);
  return !plan->is_read() && objection &&
         objection->code == modbus::ExceptionCode::illegal_function;
}

void Requests::end_unwanted(const ClientSession& session, const SettingsSnapshot& before,
                            Instant now) {
  for (const std::uint32_t exchange : session.exchanges) {
    if (is_withdrawn(session, exchanges_[exchange], now)) {
      exchanges_.cancel(exchange);
    }
  }
  for (const std::uint32_t held : session.held) {
    if (unit_means_otherwise({session.info().listener, exchanges_[held].header.unit}, before,
                             settings_.in_force())) {
      exchanges_.cancel(held);
    }
  }
}

modbus::Pdu Requests::answer_of_gateway(const ClientSession& session, const Request& asked,
                                        Instant now) {
  const modbus::Pdu& request = asked.adu.pdu;
  if (session.rights().read_only && !modbus::is_read(request.bytes())) {
    return modbus::Pdu::exception(request.function(), modbus::ExceptionCode::illegal_function);
  }
  const StatusView view{settings_.settings(), buses_, sessions_, intake_.counters(), started_, now};
  const StatusUnit::Answer answer = status_unit_.answer(request, view);
  const auto report = [&](ReportLimit& limit, auto event) {
    if (const auto left_out = limit.note(session.info(), now)) {
      event.left_out = *left_out;
      actions_.push(Report{std::move(event)});
    }
  };
  if (answer.clear_counters) {
    clear_counters();
    report(clears_, CountersCleared{asked_of(session.info(), asked.adu)});
  } else if (StatusUnit::is_elsewhere(request)) {
    report(misreads_, ReadDenied{{asked_of(session.info(), asked.adu), StatusUnit::kWhere}});
  }
  return answer.pdu;
}

void Requests::clear_counters() {
  status_unit_.clear_counters();
  intake_.clear_counters();
  buses_.touch_all([](bus::Bus& it) { it.clear_counters(); });
  sessions_.clear_counters();
}

void Requests::complete(std::uint32_t index, Instant now) {
  const Exchange& exchange = exchanges_[index];
  ClientSession* session = exchange.client_gone ? nullptr : sessions_.find(exchange.client);
  MBGATE_ASSERT(session != nullptr || exchange.client_gone,
                "a request knows whether its client is there");
  const auto adu = session == nullptr ? std::nullopt : adu_of(exchange);
  const auto answer =
      adu && !exchange.is_replaced
          ? std::optional(answer_of(*session, *adu, exchange.arrival, exchange.is_stop))
          : std::nullopt;
  const bool is_in_time = answer && now <= answer->until;
  if (trace_.is_on()) {
    trace_.answered(index, {is_in_time ? adu : std::nullopt, exchange.ended_as, now});
  }
  if (session == nullptr) {
    return;
  }
  session->exchanges.erase(std::ranges::find(session->exchanges, index));
  session->held.erase(std::ranges::remove(session->held, index).begin(), session->held.end());
  ListenerCounters& counters = sessions_.counters(exchange.listener);
  if (exchange.failed) {
    ++session->refused;
    counters.note_refused(exchange.plan->is_read(), code_of(adu->pdu), now);
  } else {
    counters.recent.note_ended(!adu || is_in_time, now);
  }
  send(*session, exchange.answer, answer, now);
  start_held(*session, now);
}

void Requests::send(ClientSession& session, AnswerId id,
                    const std::optional<DueAnswers::Answer>& answer, Instant now) {
  for (const modbus::MbapBytes& ready : session.answers.close(id, answer, now)) {
    actions_.push(Send{session.id(), ready});
  }
  sessions_.wake(session);
}

}  // namespace mbgate::gateway
