// SPDX-License-Identifier: Apache-2.0
// The actions that a bus asks of its owner, and its reports.
#pragma once

#include <cstdint>
#include <optional>
#include <variant>
#include <vector>

#include "bus/health/line_quality.hpp"
#include "bus/job.hpp"
#include "bus/line_end.hpp"

namespace mbgate::bus {

struct OpenLine {};
/// The bus wants to transmit. Hand in the bytes that can already be read from the line, then call
/// handle_looked().
struct LookAtLine {};
struct TransmitFrame {
  FrameBytes frame;
};
struct JobEnded {
  Job* job;
  Ending ending;
};
/// A fault of the line itself was noticed. Lost framing is not reported here but by CloseLine.
struct LineNotice {
  LineFault fault;
};
/// Close the line: the framing of the incoming bytes is lost, and the bus has given the line up
/// already. Or nothing comes from a server any more, or nothing that can be followed: then the
/// connection rests, and OpenLine follows when a job waits for it. Nothing needs to be reported
/// back.
struct CloseLine {};
/// Close the adapter and open it again: nothing at all is received from it. Jobs stay queued
/// meanwhile.
struct ReopenLine {
  Duration silence;
  unsigned requests;  ///< sent in this time
  bool first;         ///< the first reopening since something was received
};
/// Bytes have arrived for so long without a silence that nothing could be transmitted on the line.
struct NeverSilent {};
/// What was learned of the device at an address.
struct DeviceNotice {
  enum class Kind : std::uint8_t {
    lost,             ///< it does not answer: offline
    back,             ///< it answers again
    late,             ///< an answer came after its response timeout, and the quarantine grew
    early,            ///< an answer began before response_wait was over: it is set too long
    foreign,          ///< a request of another client, or a frame of a device that owed no answer
    second_answer,    ///< two answers came to one request
    pauses,           ///< an answer was cut, because it paused for longer than frame_slack
    misfit,           ///< it answers with good frames that do not fit what it was asked
    stop_unanswered,  ///< no matching response came to a stop, nor to its repetitions
    stop_refused,     ///< a stop was refused, and so were its repetitions, if there were any
    stop_forced       ///< a stop was transmitted although the line was never silent
  };
  Kind kind;
  std::uint8_t address;
  Duration lateness{0};         ///< late: after the response timeout; pauses: how long
  Duration quarantine{0};       ///< late: in force from now on
  bool answered_before = true;  ///< lost, back: has it ever sent a valid answer?
  unsigned transmissions = 0;   ///< lost: unanswered in a row
  bool is_request = false;      ///< foreign: it was a request
  std::uint8_t exception = 0;   ///< stop_refused: the last one
};
/// Which jobs a transmission is for. A job leads one transmission at a time.
struct TransmissionTitle {
  std::uint32_t job = 0;                  ///< number of the one that leads
  std::vector<std::uint32_t> requests{};  ///< the owners of all that share it
};
/// Only of a traced bus: a frame goes on the wire. It comes in the TransmitFrame that follows.
struct TransmissionBegan {
  TransmissionTitle title;
  std::uint8_t address;
  bool is_broadcast;
  unsigned tries;  ///< of this transaction, this one included
  /// Of a serial line: since when it is silent, and when the frame will have left it.
  std::optional<Instant> silent_since{};
  std::optional<Instant> leaves_at{};
};
/// Only of a traced bus: what became of it. One that is cut with its line has none.
struct TransmissionOver {
  TransmissionTitle title;
  LineEnd::How how;
  bool may_stay_silent;  ///< then no response is no failure
  std::optional<modbus::Pdu> response;
  std::optional<Instant> held_until{};  ///< no response: the device is quarantined, at most so long
};
using BusAction =
    std::variant<OpenLine, LookAtLine, TransmitFrame, JobEnded, LineNotice, CloseLine, ReopenLine,
                 NeverSilent, DeviceNotice, QualityNotice, TransmissionBegan, TransmissionOver>;

}  // namespace mbgate::bus
