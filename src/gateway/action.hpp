// SPDX-License-Identifier: Apache-2.0
// The actions that the machine asks of the driver, as plain values.
#pragma once

#include <variant>

#include "bus/action_queue.hpp"
#include "bus/job.hpp"
#include "gateway/client.hpp"
#include "gateway/event.hpp"
#include "modbus/mbap.hpp"

namespace mbgate::gateway {

/// Send this ADU in one piece; then hand in ClientSent.
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
/// Hand in the bytes that can already be read from the line, if there are any; then hand in
/// LineLooked.
struct Look {
  BusId bus;
};
/// Transmit this frame in one contiguous write, at once.
struct Transmit {
  BusId bus;
  bus::FrameBytes frame;
};
/// Close the line: its framing is lost, it is to be opened again, or a reload has changed it.
/// Nothing needs to be reported back.
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

using ActionQueue = bus::ActionQueue<Action>;

}  // namespace mbgate::gateway
