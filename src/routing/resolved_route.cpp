// SPDX-License-Identifier: Apache-2.0
#include "routing/resolved_route.hpp"

namespace mbgate::routing {
namespace {

bool passes(const FunctionRules& rules, const modbus::Pdu& pdu) {
  const std::uint8_t function = pdu.function();
  if (!modbus::is_request_function(function) || !rules.allowed.test(function)) {
    return false;
  }
  if (function == 0x08 && pdu.size() >= 3) {
    const std::uint16_t sub_function = modbus::load_be16(pdu.bytes(), 1);
    return sub_function != modbus::kModbusPlusStatistics &&
           (sub_function != modbus::kRestartCommunications || rules.restart_communications) &&
           (sub_function != modbus::kChangeDelimiter || rules.change_delimiter) &&
           (sub_function != modbus::kForceListenOnly || rules.force_listen_only);
  }
  return true;
}

}  // namespace

std::optional<Denial> denial_of(const ResolvedRoute& resolved, ClientRights rights,
                                const modbus::Pdu& pdu) {
  const Route& route = resolved.route;
  const bool reads = modbus::is_read(pdu.bytes());
  if (rights.read_only && !reads) {
    return Denial::read_only_client;
  }
  if (route.access == Access::read_only && !reads) {
    return Denial::read_only_route;
  }
  if (!passes(route.functions, pdu)) {
    return Denial::functions;
  }
  if (resolved.is_broadcast() && !modbus::is_broadcast_function(pdu.function())) {
    return Denial::no_broadcast;
  }
  return std::nullopt;
}

}  // namespace mbgate::routing
