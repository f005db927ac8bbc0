// SPDX-License-Identifier: Apache-2.0
// The inputs of the machine, as plain values, so that they can be recorded and replayed: the same
// inputs at the same instants give the same actions.
#pragma once

#include <chrono>
#include <string_view>
#include <variant>

#include "bus/line_discipline.hpp"
#include "bus/link_state.hpp"
#include "gateway/client.hpp"

namespace mbgate::gateway {

/// The driver numbers clients and uses no number twice. A client that is not allowed is closed.
struct ClientConnected {
  ClientId client;
  ClientInfo info;
};
/// At most kClientReadSize bytes, owned by the caller. `unread`: how many more can be read from the
/// socket. After Resume the driver hands in this input even if there is nothing to read: without
/// bytes it says that the socket was empty.
struct ClientBytes {
  ClientId client;
  modbus::Bytes bytes;
  std::size_t unread = 0;
};
/// The oldest Send that was not confirmed yet has been written whole.
struct ClientSent {
  ClientId client;
};
/// The client has sent FIN. Comes when the FIN is read; before that also once if it is noticed
/// while reading is paused.
struct ClientHalfClosed {
  ClientId client;
};
/// The connection is gone. `bytes`: of ClientBytes, but read when it was gone already; only stops
/// among them count. Unknown clients are ignored.
struct ClientDisconnected {
  ClientId client;
  modbus::Bytes bytes{};
};
struct LineOpened {
  BusId bus;
  bus::LineKind kind = bus::LineKind::virtual_line;
};
/// The bytes are owned by the caller.
struct LineBytes {
  BusId bus;
  modbus::Bytes bytes;
};
/// The driver of a serial line holds so many bytes that have not left, where that is another number
/// than it was: 0 when the line is opened. Handed in before LineLooked and DeadlineReached.
struct LineUnsent {
  BusId bus;
  std::size_t bytes;
};
/// The line could not be opened, or was lost, or the server has closed the connection. The machine
/// asks by itself to open it again.
struct LineLost {
  BusId bus;
  bus::Loss loss = bus::Loss::failed;
};
/// After Look: the bytes that could be read from the line have been handed in, and nothing else
/// since.
struct LineLooked {
  BusId bus;
};
/// The next wake has come. The driver promises that the bytes that could already be read from open
/// lines have been handed in before: no answer counts as missing that has already arrived.
struct DeadlineReached {};
/// New settings, consistent as in the constructor. Listeners, buses and devices are the same if
/// their names are, and keep their numbers (numbered_after()): Gateway::settings() has them.
/// Lines that did not change go on without losing a transaction. Shut is asked for lines that
/// changed or are removed, and Open for lines that changed and new ones. Clients are closed if
/// their listener is removed or does not allow them any more. To be handed in when poll_action()
/// has nothing left: decisions made with older settings are carried out before newer ones.
struct SettingsChanged {
  const Settings* settings = nullptr;  ///< owned by the caller, and copied
  std::string_view config{};           ///< config_lines() of what they were read from, or nothing
};
/// The driver has not run for so long, because the process was stopped or got no processor time.
/// What lies in the sockets of the clients may have waited there since: it counts as arrived then,
/// until a socket was seen empty. The driver hands it in before it looks into any of them, and then
/// looks into each, as after Resume. Until then no timeout of the client is judged.
struct Stalled {
  std::chrono::milliseconds lasted{};
};
/// All counters begin anew, as by function 08/10 to the status unit. Nothing else changes.
struct ClearCountersAsked {};
/// Nothing new is started but stops; Finished follows at most 1.5 s later.
struct ShutdownAsked {};

using Input =
    std::variant<ClientConnected, ClientBytes, ClientSent, ClientHalfClosed, ClientDisconnected,
                 LineOpened, LineBytes, LineUnsent, LineLost, LineLooked, DeadlineReached,
                 SettingsChanged, Stalled, ClearCountersAsked, ShutdownAsked>;

}  // namespace mbgate::gateway
