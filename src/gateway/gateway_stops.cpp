// SPDX-License-Identifier: Apache-2.0
// Stops, which overtake what was sent before them; who else may write now.
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

// A broadcast that is a stop may be a write like others on some of its buses.
bool Gateway::stops_on(BusId bus, const routing::Plan& stop) const {
  return stop.transactions().front().bus == stop.transactions().back().bus ||
         std::ranges::any_of(stop.transactions(),
                             [&](const auto& it) { return it.bus == bus && is_stop(it); });
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
  return objection_of_devices(id, session, plan, received, now);
}

// Why none of the devices that a write reaches, or not all of them, may be written to now.
std::optional<ExceptionCode> Gateway::objection_of_devices(ClientId id,
                                                           const ClientSession& session,
                                                           const routing::Plan& write,
                                                           const Received& received,
                                                           Instant now) const {
  std::optional<ExceptionCode> found;
  for (const routing::PlannedTransaction& transaction : write.transactions()) {
    const auto denied = objection_of_devices(id, session, transaction, received, now);
    // What is never allowed is said rather than what is not allowed now.
    if (denied && found != ExceptionCode::illegal_function) {
      found = denied;
    }
  }
  return found;
}

std::optional<ExceptionCode> Gateway::objection_of_devices(ClientId id,
                                                           const ClientSession& session,
                                                           const routing::PlannedTransaction& write,
                                                           const Received& received,
                                                           Instant now) const {
  std::optional<ExceptionCode> found;
  for (const std::size_t place : current().devices.reached_by(write)) {
    const DeviceGuard* guard = current().guard(place);
    auto denied = guard == nullptr ? std::nullopt
                                   : writers_.objection(place, *guard, session.info().address, now);
    if (!denied && (session.ahead.forbids(place, received.position) ||
                    stop_marks_.forbids(place, id, received.arrival))) {
      denied = ExceptionCode::server_device_busy;
    }
    if (denied && found != ExceptionCode::illegal_function) {
      found = denied;
    }
  }
  return found;
}

// Where a part of a stop is none, it is a write like others: it goes only if it might go alone, in
// its place among the requests of its connection and as long as its client is there.
boost::container::small_vector<BusId, 1> Gateway::left_out_of(ClientId id,
                                                              const ClientSession& session,
                                                              const routing::Plan& stop,
                                                              const Received& received,
                                                              Instant now) const {
  boost::container::small_vector<BusId, 1> left_out;
  if (stop.transactions().front().bus == stop.transactions().back().bus || !is_stop(stop)) {
    return left_out;
  }
  const bool may_go = !stopping_ && !session.is_leaving && !session.is_half_closed() &&
                      received.position == session.position();
  for (const routing::PlannedTransaction& part : stop.transactions()) {
    if (!stops_on(part.bus, stop) &&
        (!may_go || objection_of_devices(id, session, part, received, now))) {
      left_out.push_back(part.bus);
    }
  }
  return left_out;
}

void Gateway::note_accepted(const Exchange& exchange, Instant now) {
  if (exchange.plan->is_read()) {
    return;
  }
  if (exchange.is_stop) {
    for (const std::size_t place : overtaken_by(*exchange.plan)) {
      stop_marks_.note(place, exchange.client, now);
    }
  }
  for (const routing::PlannedTransaction& part : exchange.plan->transactions()) {
    if (exchange.leaves_out(part.bus) || (exchange.is_stop && stops_on(part.bus, *exchange.plan))) {
      continue;
    }
    for (const std::size_t place : current().devices.reached_by(part)) {
      writers_.note(place, exchange.address, now);
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

// What lies behind a full pipeline is looked at once, for stops. One that lets writes go first is
// looked at again as long as such a write lies before it. A client that leaves has sent what it has
// sent: all its stops are taken, however many there are.
void Gateway::take_stops_ahead(ClientId id, ClientSession& session, Instant now, bool leaving) {
  session.is_leaving = leaving;
  if (leaving) {
    drop_requests(session);  // before a stop sets the bus going
  } else if (!session.is_full()) {
    return;
  }
  const std::uint64_t front = session.position();
  // Those that kept their place have been looked at already.
  std::uint64_t at = leaving ? front : std::max(session.ahead.looked_at, front);
  std::optional<std::uint64_t> first_held;
  session.ahead.keep_writes(front, at);
  while (leaving || session.ahead.has_room()) {
    const std::size_t offset = at - front;
    const modbus::MbapScan scan = modbus::scan_mbap(session.input.bytes().subspan(offset));
    if (const auto* foreign = std::get_if<modbus::MbapForeign>(&scan)) {
      at += foreign->size;
    } else if (const auto* frame = std::get_if<modbus::MbapFrame>(&scan)) {
      const Received received{frame->adu, at, session.input.arrival_at(offset)};
      if (!look_ahead(id, session, received, now)) {
        first_held = first_held.value_or(at);
      }
      at += frame->size;
    } else {
      break;
    }
  }
  session.ahead.looked_at = first_held.value_or(at);
}

// False: it is a stop before which a write goes that lies there too.
bool Gateway::look_ahead(ClientId id, ClientSession& session, const Received& received,
                         Instant now) {
  if (session.ahead.has(received.position) || session.is_before_ready(received.position)) {
    return true;
  }
  auto plan = write_in(session, received.adu);
  if (!plan) {
    return true;
  }
  if (!is_stop(*plan)) {
    // One that its client may never make goes before nothing.
    if (objection_of_devices(id, session, *plan, received, now) !=
        ExceptionCode::illegal_function) {
      note_ahead(session, *plan, received.position);
    }
    return true;
  }
  // Only one for a single device may let writes go first.
  const bool lets_go = overtaken_by(*plan).empty();
  const DevicePlaces devices = current().devices.addressed_by(plan->transactions().front());
  if (lets_go && !session.is_leaving &&
      session.ahead.write_lies_before(devices, received.position)) {
    return false;
  }
  accept_ahead(id, session, received, *std::move(plan), now);
  return true;
}

std::optional<routing::Plan> Gateway::write_in(const ClientSession& session,
                                               const modbus::MbapAdu& adu) const {
  // Most of what waits are reads, and need no plan.
  if (modbus::is_read(adu.pdu.bytes()) || settings().own_unit == adu.header.unit) {
    return std::nullopt;
  }
  auto plan = plan_for(session, adu);
  return plan ? std::optional(*std::move(plan)) : std::nullopt;
}

void Gateway::note_ahead(ClientSession& session, const routing::Plan& write,
                         std::uint64_t position) const {
  for (const routing::PlannedTransaction& transaction : write.transactions()) {
    for (const std::size_t place : current().devices.reached_by(transaction)) {
      if (!settings().devices[place].stop_cancels) {
        session.ahead.note_write(place, position);
      }
    }
  }
}

void Gateway::accept_ahead(ClientId id, ClientSession& session, const Received& received,
                           routing::Plan plan, Instant now) {
  note_asked(id, session, now);
  session.ahead.forbid(overtaken_by(plan), received.position);
  auto left_out = left_out_of(id, session, plan, received, now);
  const std::uint32_t index = open_exchange(id, session, received.adu.header, std::move(plan));
  exchanges_[index].left_out = std::move(left_out);
  if (session.is_leaving) {
    exchanges_[index].client_gone = true;
    session.exchanges.pop_back();
    start(index, received.arrival, now);
    return;
  }
  EarlyStops::Stop stop{received.position};
  if (session.is_ordered()) {
    stop.answer_waits = true;
    stop.exchange = index;
  } else {
    exchanges_[index].answer = session.open_answer();
  }
  session.ahead.add(stop);
  start(index, received.arrival, now);
}

void Gateway::pass_taken(ClientId id, ClientSession& session, const EarlyStops::Stop& stop) {
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

}  // namespace mbgate::gateway
