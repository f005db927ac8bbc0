// SPDX-License-Identifier: Apache-2.0
// Which connection makes room for another one. Those of `keep` never do.
#pragma once

#include "gateway/clients/sessions.hpp"

namespace mbgate::gateway {

/// For another one of this client to the listener, because the client has as many as it may;
/// nullptr: none. One that has never asked goes first, then the one that has been idle longest. One
/// that waits for an answer stays.
[[nodiscard]] ClientSession* to_replace(Sessions& sessions, ListenerId listener,
                                        const ClientKey& client);
/// Because the listener is full; nullptr: none, the newcomer is refused. One of the client that has
/// most of them, the newcomer counted: one that has never asked, else the one that has been idle
/// longest, else the oldest. Where each client has one, only one that has never asked.
[[nodiscard]] ClientSession* to_displace(Sessions& sessions, ListenerId listener,
                                         const ClientKey& newcomer);

}  // namespace mbgate::gateway
