// SPDX-License-Identifier: Apache-2.0
// Stops, which overtake what was sent before them; who else may write now; failsafe writes.
#include <algorithm>

#include "gateway/gateway.hpp"
#include "gateway/limits.hpp"

namespace mbgate::gateway {

using modbus::ExceptionCode;

bool Gateway::is_stop(const routing::PlannedTransaction& transaction) const {
  return buses_[static_cast<std::size_t>(transaction.bus)]->bus.is_stop(
      transaction.address, transaction.request, transaction.broadcast);
}

// As the buses decide it: a run of writes is a stop if each of them is, a broadcast if anybody
// takes it for one.
bool Gateway::is_stop(const routing::Plan& plan) const {
  const auto part_stops = [this](const auto& it) { return is_stop(it); };
  const bool for_all = plan.transactions().back().broadcast != drive::BroadcastForm::none;
  return !plan.is_read() && (for_all ? std::ranges::any_of(plan.transactions(), part_stops)
                                     : std::ranges::all_of(plan.transactions(), part_stops));
}

// Why a request that could be planned is not carried out now. Stops go until the process ends, but
// not those of another time.
std::optional<ExceptionCode> Gateway::objection(ClientId id, const ClientSession& session,
                                                const routing::Plan& plan, const Received& received,
                                                Instant now) const {
  constexpr auto kNotNow = ExceptionCode::server_device_busy;
  if (plan.is_read()) {
    return stopping_ ? std::optional(kNotNow) : std::nullopt;
  }
  if (session.is_before_ready(received.position)) {
    return kNotNow;
  }
  if (is_stop(plan)) {
    return stopping_ && !stop_deadline_ ? std::optional(kNotNow) : std::nullopt;
  }
  if (stopping_ || session.is_half_closed()) {
    return kNotNow;
  }
  std::optional<ExceptionCode> found;
  for (const routing::PlannedTransaction& transaction : plan.transactions()) {
    for (const std::size_t place : current().devices.reached_by(transaction)) {
      if (session.ahead.forbids(place, received.position) ||
          stop_marks_.forbids(place, id, received.arrival)) {
        return kNotNow;
      }
      const DeviceGuard* guard = current().guard(place);
      const auto denied = guard == nullptr
                              ? std::nullopt
                              : writers_.objection(place, *guard, session.info().address, now);
      // What is never allowed is said rather than what is not allowed now.
      if (denied && found != ExceptionCode::illegal_function) {
        found = denied;
      }
    }
  }
  return found;
}

void Gateway::note_accepted(const Exchange& exchange, Instant now) {
  if (exchange.is_stop) {
    for (const std::size_t place : overtaken_by(*exchange.plan)) {
      stop_marks_.note(place, exchange.client, now);
    }
  } else if (!exchange.plan->is_read()) {
    for (const routing::PlannedTransaction& transaction : exchange.plan->transactions()) {
      for (const std::size_t place : current().devices.reached_by(transaction)) {
        writers_.note(place, exchange.address, now);
      }
    }
  }
}

// The devices to which writes that came before the stop are not transmitted any more.
DevicePlaces Gateway::overtaken_by(const routing::Plan& stop) const {
  DevicePlaces overtaken;
  for (const routing::PlannedTransaction& transaction : stop.transactions()) {
    for (const std::size_t place : current().devices.addressed_by(transaction)) {
      const drive::Device& device = settings().devices[place];
      const bool for_all = transaction.broadcast != drive::BroadcastForm::none;
      if ((device.stop_cancels || for_all) && device.is_stop(transaction.request)) {
        overtaken.push_back(place);
      }
    }
  }
  return overtaken;
}

// What lies behind a full pipeline is looked at once, for stops; one that lets the writes before it
// run keeps its place. A client that leaves has sent what it has sent: all its stops are taken,
// however many there are.
void Gateway::take_stops_ahead(ClientId id, ClientSession& session, Instant now, bool leaving) {
  if (!leaving && !session.is_full()) {
    return;
  }
  const std::uint64_t front = session.position();
  std::uint64_t at = std::max(session.ahead.looked_at, front);
  while (leaving || session.ahead.has_room()) {
    const std::size_t offset = at - front;
    const modbus::MbapScan scan = modbus::scan_mbap(session.input.bytes().subspan(offset));
    if (const auto* foreign = std::get_if<modbus::MbapForeign>(&scan)) {
      at += foreign->size;
    } else if (const auto* frame = std::get_if<modbus::MbapFrame>(&scan)) {
      auto plan = stop_in(session, frame->adu);
      if (plan && !session.is_before_ready(at) && (leaving || !overtaken_by(*plan).empty())) {
        accept_ahead(id, session, {frame->adu, at, session.input.arrival_at(offset)},
                     *std::move(plan), now);
      }
      at += frame->size;
    } else {
      break;
    }
  }
  session.ahead.looked_at = at;
}

std::optional<routing::Plan> Gateway::stop_in(const ClientSession& session,
                                              const modbus::MbapAdu& adu) const {
  // Nothing but a plain write can be a stop, and most of what waits are reads.
  if (!modbus::is_broadcast_function(adu.pdu.function()) ||
      settings().own_unit == adu.header.unit) {
    return std::nullopt;
  }
  auto plan = plan_for(session, adu);
  return plan && is_stop(*plan) ? std::optional(*std::move(plan)) : std::nullopt;
}

void Gateway::accept_ahead(ClientId id, ClientSession& session, const Received& received,
                           routing::Plan plan, Instant now) {
  ++client_counters_.requests;
  failsafe_.client_asked(id, now);
  session.ahead.forbid(overtaken_by(plan), received.position);
  const std::uint32_t index = open_exchange(id, session, received.adu.header, std::move(plan));
  TakenAhead::Stop stop{received.position};
  if (session.is_ordered()) {
    stop.answer_waits = true;
    stop.exchange = index;
  } else {
    exchanges_[index].answer = session.open_answer();
  }
  session.ahead.add(stop);
  start(index, received.arrival, now);
}

void Gateway::pass_taken(ClientId id, ClientSession& session, const TakenAhead::Stop& stop) {
  if (!stop.answer_waits) {
    return;
  }
  const auto answer = session.open_answer();
  if (stop.exchange) {
    exchanges_[*stop.exchange].answer = answer;
  } else {
    send(id, session, answer, stop.answer);
  }
}

void Gateway::send_failsafe(const Failsafe::Due& due, Instant now) {
  const drive::Device& device = settings().devices[due.device];
  report(FailsafeSent{device.bus, device.address, due.silence});
  if (device.stop_cancels) {
    stop_marks_.note(due.device, std::nullopt, now);
  }
  const std::uint32_t index = exchanges_.take();
  Exchange& exchange = exchanges_[index];
  exchange.generation = &current();
  ++exchange.generation->exchanges;
  exchange.client_gone = true;
  exchange.is_stop = true;
  const Duration longest =
      buses_[static_cast<std::size_t>(device.bus)]->bus.longest_response_timeout();
  for (const modbus::Request& write : current().guard(due.device)->failsafe) {
    bus::Job& job = new_job(index, now + write_deadline(longest));
    job.job_class = bus::JobClass::stop;
    job.transactions.push_back({device.address, write});
    exchange.parts.push_back({device.bus, &job});
  }
  submit_parts(exchange, now);
}

}  // namespace mbgate::gateway
