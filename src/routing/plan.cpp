// SPDX-License-Identifier: Apache-2.0
#include "routing/plan.hpp"

#include "modbus/rtu.hpp"
#include "routing/address_window.hpp"
#include "routing/broadcast_plan.hpp"
#include "routing/device_plan.hpp"
#include "routing/special_writes.hpp"

namespace mbgate::routing {
namespace {

using modbus::ExceptionCode;
using modbus::Request;

bool may_be_silent(const Request& request) {
  if (request.function() != 0x08) {
    return false;
  }
  const std::uint16_t sub_function = modbus::load_be16(request.pdu().bytes(), 1);
  return sub_function == modbus::kRestartCommunications || sub_function == modbus::kForceListenOnly;
}

// What a request to a device that nothing is known of becomes: itself.
DevicePlan as_it_is(const Request& client_request, const Request& request) {
  DevicePlan plan{{request}, {}};
  if (request.writes() && !request.reads()) {
    plan.reply.form = Reply::Form::echo;
  } else if (request.function() != client_request.function()) {
    plan.reply.form = request.reads()->range.table == modbus::Table::holding_registers ||
                              request.reads()->range.table == modbus::Table::input_registers
                          ? Reply::Form::registers
                          : Reply::Form::bits;
  }
  return plan;
}

}  // namespace

Result<Plan, ExceptionCode> Plan::make(const Way& way, std::uint8_t unit, ClientRights rights,
                                       const modbus::Pdu& pdu) {
  const Route& route = way.route;
  if (!is_allowed(way, rights, pdu)) {
    return ExceptionCode::illegal_function;
  }
  const auto client_request = Request::parse(pdu);
  if (!client_request) {
    return client_request.error();
  }
  const auto request =
      route.windows.empty() ? client_request : through_windows(route.windows, *client_request);
  if (!request) {
    return request.error();
  }
  Plan plan(*client_request);
  const auto address = static_cast<std::uint8_t>(route.first_address + (unit - route.first_unit));
  const auto error = way.is_broadcast() ? plan.add_broadcast(way, *request)
                                        : plan.add_requests(way, address, *request);
  if (error) {
    return *error;
  }
  return plan;
}

std::optional<ExceptionCode> Plan::add_broadcast(const Way& way, const Request& request) {
  const auto frames = plan_broadcast(way, request);
  if (!frames) {
    return frames.error();
  }
  reply_.form = Reply::Form::echo;
  for (const BroadcastFrame& frame : *frames) {
    const auto address = frame.form == drive::BroadcastForm::autonics ? kAutonicsBroadcastAddress
                                                                      : modbus::kBroadcastAddress;
    transactions_.push_back({frame.bus, address, frame.request, false, frame.form});
  }
  return std::nullopt;
}

std::optional<ExceptionCode> Plan::add_requests(const Way& way, std::uint8_t address,
                                                const Request& request) {
  DevicePlan planned;
  if (way.device == nullptr) {
    planned = as_it_is(client_request_, request);
  } else {
    auto made = plan_for(*way.device, way.route.word_order, request);
    if (!made) {
      return made.error();
    }
    planned = *std::move(made);
    orders_words_ = way.route.word_order && touches_value(*way.device, request);
  }
  reply_ = planned.reply;
  for (const Request& asked : planned.requests) {
    const bool known = way.device == nullptr || way.route.functions_named ||
                       way.device->profile.functions.test(asked.function());
    if (!known) {
      return ExceptionCode::illegal_function;
    }
    transactions_.push_back({way.route.buses.front(), address, asked, may_be_silent(asked)});
  }
  return std::nullopt;
}

modbus::Pdu Plan::answer(Responses responses) const {
  boost::container::small_vector<std::uint16_t, 4> counts;
  for (const PlannedTransaction& transaction : transactions_) {
    const auto& reads = transaction.request.reads();
    counts.push_back(reads ? reads->range.count : std::uint16_t{0});
  }
  return assemble(reply_, client_request_, responses, counts);
}

}  // namespace mbgate::routing
