// SPDX-License-Identifier: Apache-2.0
// Decides for each request whether its client may make it on this route; a denied one gets
// exception 01.
#pragma once

#include <cstdint>
#include <optional>

#include "modbus/pdu.hpp"
#include "routing/resolved_route.hpp"

namespace mbgate::routing {

/// What a client may do, by its address on its listener.
struct ClientRights {
  bool read_only = false;
};

/// What does not allow a request.
enum class Denial : std::uint8_t { functions, read_only_client, read_only_route, no_broadcast };

/// Function codes, sub-functions of 08 (21 never), read-only routes and clients; broadcasts are 05,
/// 06, 15, 16 only. Nothing if it is allowed.
[[nodiscard]] std::optional<Denial> denial_of(const ResolvedRoute& resolved, ClientRights rights,
                                              const modbus::Pdu& pdu);

}  // namespace mbgate::routing
