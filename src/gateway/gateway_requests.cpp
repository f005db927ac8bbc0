// SPDX-License-Identifier: Apache-2.0
// The way of a request through the machine, out and back.
#include <algorithm>

#include "gateway/gateway.hpp"
#include "gateway/limits.hpp"

namespace mbgate::gateway {

using modbus::ExceptionCode;

void Gateway::take_input(ClientId id, ClientSession& session, Instant now) {
  if (session.input.empty() || !may_take(session)) {
    return;
  }
  const std::size_t taken = take_requests(id, session, session.input.bytes(), std::nullopt, now);
  if (sessions_.contains(id) && taken > 0) {
    session.input.consume(taken);
  }
}

// Takes whole requests off the front of `stream` while the pipeline has room; returns how many
// bytes that was. Without an `arrival` the stream is the session's own input and says itself how
// old it is.
std::size_t Gateway::take_requests(ClientId id, ClientSession& session, modbus::Bytes stream,
                                   std::optional<Instant> arrival, Instant now) {
  std::size_t taken = 0;
  while (may_take(session)) {
    const modbus::Bytes rest = stream.subspan(taken);
    const modbus::MbapScan scan = modbus::scan_mbap(rest);
    if (const auto* lost = std::get_if<modbus::MbapLost>(&scan)) {
      lose_framing(id, session, rest, lost->length);
      return taken;
    }
    if (const auto* foreign = std::get_if<modbus::MbapForeign>(&scan)) {
      notice_rtu(session, rest);
      ++client_counters_.foreign_adus;
      session.pass(foreign->size);
      taken += foreign->size;
    } else if (const auto* frame = std::get_if<modbus::MbapFrame>(&scan)) {
      const std::uint64_t position = session.position();
      if (const auto stop = session.ahead.take(position)) {
        pass_taken(id, session, *stop);
      } else {
        const Instant since = arrival ? *arrival : session.input.arrival_at(taken);
        accept(id, session, {frame->adu, position, since}, now);
      }
      session.pass(frame->size);
      taken += frame->size;
    } else {
      break;
    }
    session.partial_since.reset();
  }
  return taken;
}

void Gateway::lose_framing(ClientId id, ClientSession& session, modbus::Bytes stream,
                           std::uint16_t length) {
  notice_rtu(session, stream);
  ++client_counters_.framing_lost;
  if (!session.speaks_rtu_reported) {
    report(ClientFramingLost{session.info().listener, session.info().address, length});
  }
  close(id);
}

void Gateway::notice_rtu(ClientSession& session, modbus::Bytes stream) {
  if (!session.speaks_rtu_reported && modbus::looks_like_rtu(stream)) {
    session.speaks_rtu_reported = true;
    report(ClientSpeaksRtu{session.info().listener, session.info().address});
  }
}

void Gateway::accept(ClientId id, ClientSession& session, const Received& received, Instant now) {
  const modbus::MbapAdu& adu = received.adu;
  note_asked(id, session, now);
  if (settings().own_unit == adu.header.unit) {
    answer_now(id, session, adu.header, answer_status_unit(session, adu.pdu, now));
    return;
  }
  auto plan = plan_for(session, adu);
  const auto refused =
      plan ? objection(id, session, *plan, received, now) : std::optional(plan.error());
  if (refused) {
    notice_unrouted(session, adu.header.unit);
    answer_now(id, session, adu.header, modbus::Pdu::exception(adu.pdu.function(), *refused));
    return;
  }
  auto left_out = left_out_of(id, session, *plan, received, now);
  const std::uint32_t index = open_exchange(id, session, adu.header, *std::move(plan));
  exchanges_[index].left_out = std::move(left_out);
  exchanges_[index].answer = session.open_answer();
  start(index, received.arrival, now);
}

void Gateway::notice_unrouted(const ClientSession& session, std::uint8_t unit) {
  const ClientInfo& info = session.info();
  if (resolved_route_of(session, unit) == nullptr && unrouted_told_.size() < kUnroutedTold &&
      unrouted_told_.emplace(info.listener, info.address).second) {
    report(UnitNotRouted{info.listener, info.address, unit, current().routes.units(info.listener)});
  }
}

std::uint32_t Gateway::open_exchange(ClientId id, ClientSession& session,
                                     const modbus::MbapHeader& header, routing::Plan plan) {
  const std::uint32_t index = exchanges_.take();
  Exchange& exchange = exchanges_[index];
  exchange.snapshot = &current();
  ++exchange.snapshot->exchanges;
  exchange.client = id;
  exchange.listener = session.info().listener;
  exchange.header = header;
  exchange.address = session.info().address;
  exchange.is_stop = is_stop(plan);
  exchange.plan = std::move(plan);
  session.exchanges.push_back(index);
  return index;
}

modbus::Pdu Gateway::answer_status_unit(const ClientSession& session, const modbus::Pdu& request,
                                        Instant now) {
  if (session.rights().read_only && !modbus::is_read(request.bytes())) {
    return modbus::Pdu::exception(request.function(), ExceptionCode::illegal_function);
  }
  StatusView view{{}, settings().devices, sessions_.size(), client_counters_, now - started_, now};
  for (const auto& slot : buses_) {
    view.buses.push_back(&slot->bus);
  }
  const StatusUnit::Answer answer = status_unit_.answer(request, view);
  if (answer.clear_counters) {
    client_counters_ = {};
    std::ranges::for_each(buses_, [](auto& slot) { slot->bus.clear_counters(); });
  }
  return answer.pdu;
}

Result<routing::Plan, ExceptionCode> Gateway::plan_for(const ClientSession& session,
                                                       const modbus::MbapAdu& adu) const {
  if (!modbus::is_request_function(adu.pdu.function())) {
    return ExceptionCode::illegal_function;
  }
  const routing::ResolvedRoute* resolved = resolved_route_of(session, adu.header.unit);
  if (resolved == nullptr) {
    return ExceptionCode::gateway_path_unavailable;
  }
  return routing::Plan::make(*resolved, adu.header.unit, session.rights(), adu.pdu);
}

Duration Gateway::deadline_of(const routing::Route& route, const routing::Plan& plan) const {
  if (route.deadline) {
    return *route.deadline;
  }
  Duration longest{0};
  for (const BusId bus : route.buses) {
    const bus::Bus& target = buses_[static_cast<std::size_t>(bus)]->bus;
    longest = std::max(longest, target.longest_response_timeout());
  }
  return plan.is_read() ? read_deadline(longest) : write_deadline(longest);
}

void Gateway::answer_now(ClientId id, ClientSession& session, const modbus::MbapHeader& header,
                         const modbus::Pdu& pdu) {
  send(id, session, session.open_answer(), modbus::MbapAdu{header, pdu});
}

void Gateway::send(ClientId id, ClientSession& session, ClientSession::AnswerId answer,
                   const std::optional<modbus::MbapAdu>& adu) {
  const auto bytes = adu ? std::optional(modbus::encode(*adu)) : std::nullopt;
  for (const modbus::MbapBytes& ready : session.close_answer(answer, bytes)) {
    actions_.push(Send{id, ready});
  }
  ready_clients_.push_back(id);
}

}  // namespace mbgate::gateway
