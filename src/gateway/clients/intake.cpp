// SPDX-License-Identifier: Apache-2.0
#include "gateway/clients/intake.hpp"

#include <limits>

#include "gateway/limits.hpp"

namespace mbgate::gateway {

using modbus::ExceptionCode;

Intake::Front Intake::front(ClientSession& session) {
  // When the gateway stops, or the client goes, all that was read is looked at.
  while (!session.input.empty() &&
         (phase_ != Phase::running || session.is_leaving || !session.is_full())) {
    modbus::MbapScan scan = modbus::scan_mbap(session.input.bytes());
    if (auto* frame = std::get_if<modbus::MbapFrame>(&scan)) {
      session.has_asked = true;
      return {.frame = std::move(*frame)};
    }
    if (const auto* lost = std::get_if<modbus::MbapLost>(&scan)) {
      notice_rtu(session, session.input.bytes());
      ++counters_.framing_lost;
      if (!session.speaks_rtu_reported) {
        actions_.push(Report{ClientFramingLost{asker_of(session.info()), lost->length,
                                               modbus::other_protocol(session.input.bytes())}});
      }
      return {.framing_lost = true};
    }
    const auto* foreign = std::get_if<modbus::MbapForeign>(&scan);
    if (foreign == nullptr) {
      break;
    }
    notice_rtu(session, session.input.bytes());
    ++counters_.foreign_adus;
    session.pass(foreign->size);
  }
  return {};
}

Request& Intake::take(ClientSession& session, const modbus::MbapFrame& frame, Instant now) {
  ++counters_.requests;
  return read(session, frame, now);
}

Request* Intake::take_stop(ClientSession& session, Instant now) {
  for (Front next = front(session); next.frame; next = front(session)) {
    Request& request = read(session, *next.frame, now);
    if (request.is_stop && !request.refused) {
      ++counters_.requests;
      return &request;
    }
  }
  return nullptr;
}

Request& Intake::read(ClientSession& session, const modbus::MbapFrame& frame, Instant now) {
  Request& request = understand(session, frame.adu);
  judge(session, request, now);
  session.pass(frame.size);
  return request;
}

Request& Intake::understand(const ClientSession& session, const modbus::MbapAdu& adu) {
  Request& request = request_.emplace(adu, session.input);
  if (settings_.settings().status_unit == adu.header.unit) {
    request.for_gateway = true;
    apply_rules(session, request);
    return request;
  }
  request.route = settings_.in_force().routes.find(session.info().listener, adu.header.unit);
  if (!modbus::is_request_function(adu.pdu.function())) {
    request.refused = ExceptionCode::illegal_function;
  } else if (request.route == nullptr) {
    request.refused = ExceptionCode::gateway_path_unavailable;
  } else {
    auto plan = routing::Plan::make(*request.route, adu.header.unit, session.rights(), adu.pdu);
    if (plan) {
      request.is_stop = rules_.is_stop(*plan);
      request.plan = *std::move(plan);
    } else {
      request.refused = plan.error();
    }
  }
  apply_rules(session, request);
  return request;
}

// What is denied by a rule is not told whether it could have been done.
void Intake::apply_rules(const ClientSession& session, Request& request) const {
  request.verdict = verdict_on(settings_.in_force(), session.info(), request.adu.header.unit,
                               request.adu.pdu, request.plan ? &*request.plan : nullptr);
  if (!request.verdict.permitted) {
    request.for_gateway = request.is_stop = false;
    request.plan.reset();
    request.refused = ExceptionCode::illegal_function;
  }
}

void Intake::judge(const ClientSession& session, Request& request, Instant now) {
  if (is_outdated(session, request)) {
    request.for_gateway = false;
    request.plan.reset();
    request.refused = ExceptionCode::server_device_busy;
  } else {
    if (request.plan) {
      request.refused = objection(session, request, now);
    }
    const auto event =
        is_denied(session, request, now)
            ? denials_.note(settings_.in_force(), rules_, session.info(), request.adu, now)
            : std::nullopt;
    if (event) {
      actions_.push(Report{*event});
    }
  }
  const bool is_limited = (request.plan || request.for_gateway) && !request.is_stop;
  if (is_limited && !request.refused && !access_.take(request.verdict, session.key(), now)) {
    request.for_gateway = false;
    request.refused = ExceptionCode::server_device_busy;
  }
  if (request.refused) {
    notice_unrouted(session, request);
  }
}

// Why a request that could be planned is not carried out now. Stops go until the process ends, but
// not those of another time.
std::optional<ExceptionCode> Intake::objection(const ClientSession& session, const Request& request,
                                               Instant now) const {
  constexpr auto kNotNow = ExceptionCode::server_device_busy;
  const routing::Plan& plan = *request.plan;
  const bool is_running = phase_ == Phase::running;
  if (plan.is_read()) {
    return is_running ? std::nullopt : std::optional(kNotNow);
  }
  if (request.is_stop) {
    return phase_ == Phase::nothing ? std::optional(kNotNow) : std::nullopt;
  }
  const bool is_of_before = request.arrival == Instant::min();
  if (!is_running || session.is_half_closed() || is_of_before) {
    return kNotNow;
  }
  const auto found = rules_.objection(plan, request.origin(session), now);
  return found ? std::optional(found->code) : std::nullopt;
}

// Its client meant the drive to which the unit led then. Where it leads nowhere now, that is said.
// Only writes are as old as their socket; reads count from now. A stop goes all the same: what lies
// in a socket may count as older than it is, and a stop that is refused for that is a stop lost.
bool Intake::is_outdated(const ClientSession& session, const Request& request) const {
  if (request.is_stop || modbus::is_read(request.adu.pdu.bytes())) {
    return false;
  }
  const auto changed = changed_at_.find({session.info().listener, request.adu.header.unit});
  return changed != changed_at_.end() && request.arrival < changed->second &&
         (request.route != nullptr || request.for_gateway);
}

void Intake::adopt(const SettingsSnapshot& before, Instant now) {
  unrouted_reported_.clear();
  access_.forget_rates();
  for (std::size_t listener = 0; listener < before.settings.listeners.size(); ++listener) {
    for (unsigned unit = 0; unit <= std::numeric_limits<std::uint8_t>::max(); ++unit) {
      const UnitOfListener place{static_cast<ListenerId>(listener),
                                 static_cast<std::uint8_t>(unit)};
      if (unit_means_otherwise(place, before, settings_.in_force())) {
        changed_at_[place] = now;
      }
    }
  }
}

void Intake::notice_unrouted(const ClientSession& session, const Request& request) {
  const ClientInfo& info = session.info();
  const bool is_unrouted = request.route == nullptr && request.verdict.permitted &&
                           request.refused != ExceptionCode::server_device_busy;
  if (is_unrouted && unrouted_reported_.size() < kUnroutedTold &&
      unrouted_reported_.emplace(info.listener, info.address.counted_as()).second) {
    actions_.push(Report{UnitNotRouted{asker_of(info), request.adu.header.unit,
                                       settings_.in_force().routes.units(info.listener)}});
  }
}

// Is it refused because somebody has said that this client may not do it? Not: because of what it
// is, or because it cannot be done now.
bool Intake::is_denied(const ClientSession& session, const Request& request, Instant now) const {
  if (!request.verdict.permitted) {
    return true;
  }
  const modbus::Pdu& pdu = request.adu.pdu;
  const bool is_read = modbus::is_read(pdu.bytes());
  if (request.for_gateway) {
    return session.rights().read_only && !is_read;
  }
  if (!request.refused || request.route == nullptr ||
      !modbus::is_request_function(pdu.function())) {
    return false;
  }
  if (request.plan) {
    const auto objection = rules_.objection(*request.plan, request.origin(session), now);
    return !is_read && objection && objection->by_writer;
  }
  const bool is_outside = request.refused == ExceptionCode::illegal_data_address &&
                          !request.route->route.windows.empty();
  return is_read ? routing::denial_of(*request.route, session.rights(), pdu).has_value()
                 : request.refused == ExceptionCode::illegal_function || is_outside;
}

void Intake::notice_rtu(ClientSession& session, modbus::Bytes stream) {
  if (!session.speaks_rtu_reported && modbus::looks_like_rtu(stream)) {
    session.speaks_rtu_reported = true;
    actions_.push(Report{ClientSpeaksRtu{asker_of(session.info())}});
  }
}

}  // namespace mbgate::gateway
