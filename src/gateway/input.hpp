// SPDX-License-Identifier: Apache-2.0
// What goes into the machine, as plain values. What can be kept can be repeated: the same inputs at
// the same instants give the same actions.
#pragma once

#include <string_view>
#include <variant>

#include "bus/line_discipline.hpp"
#include "bus/link_state.hpp"
#include "gateway/client.hpp"

namespace mbgate::gateway {

/// The driver numbers clients and uses no number twice. A client that is not wanted is closed.
struct ClientConnected {
  ClientId client;
  ClientInfo info;
};
/// At most kClientReadSize bytes, which belong to somebody else, and how many still lie in the
/// socket behind them. After Resume the driver reads even if there is nothing: no bytes then say
/// that the socket was empty.
struct ClientBytes {
  ClientId client;
  modbus::Bytes bytes;
  std::size_t unread = 0;
};
/// The oldest Send that was not confirmed yet has been written whole.
struct ClientSent {
  ClientId client;
};
/// FIN: once when it is noticed while reading is paused, and when reading comes to it.
struct ClientHalfClosed {
  ClientId client;
};
/// The connection is gone. Unknown clients are ignored.
struct ClientDisconnected {
  ClientId client;
};
struct LineOpened {
  BusId bus;
  bus::LineKind kind = bus::LineKind::virtual_line;
};
/// The bytes belong to somebody else.
struct LineBytes {
  BusId bus;
  modbus::Bytes bytes;
};
/// The line could not be opened, or died, or the far end of a connection has closed it. The machine
/// asks again by itself.
struct LineLost {
  BusId bus;
  bus::Loss loss = bus::Loss::failed;
};
/// After Look: what lay in the line has been handed in, and nothing else since.
struct LineLooked {
  BusId bus;
};
/// The driver promises that what already lay in the descriptors of open lines has been handed in
/// before: nothing is judged that could have been known.
struct DeadlineReached {};
/// Other settings from now on, consistent as in the constructor. Listeners, buses and devices are
/// the same if their names are, and keep their numbers (settings/numbering): Gateway::settings()
/// has them. Lines that did not change go on without losing a transaction; Shut is asked for those
/// that changed or are no more, and Open for those that changed and new ones. Clients of listeners
/// that are no more, or do not allow them any more, are closed. To be handed in when poll_action()
/// has nothing left: what older settings have decided is carried out before newer ones.
struct SettingsChanged {
  const Settings* settings = nullptr;  ///< of somebody else, and copied
  std::string_view config{};           ///< what they were read from, for a recording
};
/// Nothing new is begun but stops; Finished follows at most 1.5 s later.
struct ShutdownAsked {};

using Input = std::variant<ClientConnected, ClientBytes, ClientSent, ClientHalfClosed,
                           ClientDisconnected, LineOpened, LineBytes, LineLost, LineLooked,
                           DeadlineReached, SettingsChanged, ShutdownAsked>;

}  // namespace mbgate::gateway
