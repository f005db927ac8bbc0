// SPDX-License-Identifier: Apache-2.0
// What the machine wants done. Actions are plain values with a text form, so that tracing is
// printing.
#pragma once

#include <string>
#include <variant>

#include "bus/job.hpp"
#include "gateway/client.hpp"
#include "gateway/event.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::gateway {

/// Send this ADU in one piece; then ClientSent is to be handed in.
struct Send {
  ClientId client;
  modbus::MbapBytes adu;
};
/// Stop reading from the client, but watch for its FIN.
struct Pause {
  ClientId client;
};
struct Resume {
  ClientId client;
};
/// Close the connection. The machine has forgotten the client already: nothing needs to be reported
/// back. What was given to Send before is still sent.
struct Close {
  ClientId client;
};
/// Open the line; then hand in LineOpened or LineLost.
struct Open {
  BusId bus;
};
/// Hand in what already lies in the line's descriptor, if anything does; then call
/// handle_bus_looked().
struct Look {
  BusId bus;
};
/// Transmit this frame in one contiguous write, at once.
struct Transmit {
  BusId bus;
  bus::FrameBytes frame;
};
/// Close the line: what comes in there cannot be followed any further. Nothing needs to be reported
/// back.
struct Shut {
  BusId bus;
};
struct Report {
  Event event;
};
/// After ShutdownAsked: everything is answered, the process may end.
struct Finished {};

using Action =
    std::variant<Send, Pause, Resume, Close, Open, Look, Transmit, Shut, Report, Finished>;

/// One line for a trace. The settings give the names.
std::string to_text(const Action& action, const Settings& settings);

}  // namespace mbgate::gateway
