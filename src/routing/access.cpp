// SPDX-License-Identifier: Apache-2.0
#include "routing/access.hpp"

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
           (sub_function != modbus::kForceListenOnly || rules.force_listen_only);
  }
  return true;
}

}  // namespace

bool is_allowed(const ResolvedRoute& resolved, ClientRights rights, const modbus::Pdu& pdu) {
  const Route& route = resolved.route;
  const bool read_only = rights.read_only || route.access == Access::read_only;
  return passes(route.functions, pdu) && (!read_only || modbus::is_read(pdu.bytes())) &&
         (!resolved.is_broadcast() || modbus::is_broadcast_function(pdu.function()));
}

}  // namespace mbgate::routing
