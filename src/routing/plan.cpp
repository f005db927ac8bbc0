// SPDX-License-Identifier: Apache-2.0
#include "routing/plan.hpp"

#include "modbus/rtu.hpp"
#include "routing/address_window.hpp"

namespace mbgate::routing {
namespace {

using modbus::ExceptionCode;

bool may_be_silent(const modbus::Request& request) {
  if (request.function() != 0x08) {
    return false;
  }
  const std::uint16_t sub_function = modbus::load_be16(request.pdu().bytes(), 1);
  return sub_function == modbus::kRestartCommunications || sub_function == modbus::kForceListenOnly;
}

}  // namespace

Result<Plan, ExceptionCode> Plan::make(const Route& route, std::uint8_t unit, ClientRights rights,
                                       const modbus::Pdu& pdu) {
  if (!is_allowed(route, rights, pdu)) {
    return ExceptionCode::illegal_function;
  }
  const auto request = modbus::Request::parse(pdu);
  if (!request) {
    return request.error();
  }
  modbus::Request device_request = *request;
  if (!route.windows.empty()) {
    const auto moved = through_window(route.windows.front(), *request);
    if (!moved) {
      return ExceptionCode::illegal_data_address;
    }
    device_request = *moved;
  }
  const auto address =
      route.is_broadcast()
          ? modbus::kBroadcastAddress
          : static_cast<std::uint8_t>(route.first_address + (unit - route.first_unit));
  Plan plan(*request, !route.windows.empty());
  for (const BusId bus : route.buses) {
    plan.transactions_.push_back(
        {bus, address, device_request, may_be_silent(device_request),
         route.is_broadcast() ? drive::BroadcastForm::standard : drive::BroadcastForm::none});
  }
  return plan;
}

modbus::Pdu Plan::answer(const modbus::Pdu& response) const {
  return rewritten_ ? back_through_window(client_request_, response) : response;
}

}  // namespace mbgate::routing
