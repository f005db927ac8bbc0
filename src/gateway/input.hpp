// SPDX-License-Identifier: Apache-2.0
// What goes into the machine, as plain values: one for each handle_*() but handle_settings(). What
// can be kept can be repeated: the same inputs at the same instants give the same actions.
#pragma once

#include <variant>

#include "gateway/gateway.hpp"

namespace mbgate::gateway {

struct ClientConnected {
  ClientId client;
  ClientInfo info;
};
/// The bytes belong to somebody else, as in handle_client_bytes().
struct ClientBytes {
  ClientId client;
  modbus::Bytes bytes;
  std::size_t unread = 0;
};
struct ClientSent {
  ClientId client;
};
struct ClientHalfClosed {
  ClientId client;
};
struct ClientDisconnected {
  ClientId client;
};
struct LineOpened {
  BusId bus;
  bus::LineKind kind = bus::LineKind::virtual_line;
};
/// The bytes belong to somebody else, as in handle_bus_bytes().
struct LineBytes {
  BusId bus;
  modbus::Bytes bytes;
};
struct LineLost {
  BusId bus;
  bus::Loss loss = bus::Loss::failed;
};
struct LineLooked {
  BusId bus;
};
struct DeadlineReached {};
struct ShutdownAsked {};

using Input =
    std::variant<ClientConnected, ClientBytes, ClientSent, ClientHalfClosed, ClientDisconnected,
                 LineOpened, LineBytes, LineLost, LineLooked, DeadlineReached, ShutdownAsked>;

/// Hands the input over at the door it belongs to.
void apply(Gateway& gateway, const Input& input, Instant now);

}  // namespace mbgate::gateway
