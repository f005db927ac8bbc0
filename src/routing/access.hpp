// SPDX-License-Identifier: Apache-2.0
// May this client do this on this route? Decided for each request; what is denied gets exception
// 01.
#pragma once

#include "modbus/pdu.hpp"
#include "routing/resolved_route.hpp"

namespace mbgate::routing {

/// What a client may do, by its address on its listener.
struct ClientRights {
  bool read_only = false;
};

/// Function codes, sub-functions of 08 (21 never), read-only routes and clients; broadcasts are 05,
/// 06, 15, 16 only.
[[nodiscard]] bool is_allowed(const ResolvedRoute& resolved, ClientRights rights,
                              const modbus::Pdu& pdu);

}  // namespace mbgate::routing
