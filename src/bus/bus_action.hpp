// SPDX-License-Identifier: Apache-2.0
// What a bus wants of its owner, and what it tells.
#pragma once

#include <variant>

#include "bus/health/line_quality.hpp"
#include "bus/job.hpp"
#include "bus/line_end.hpp"

namespace mbgate::bus {

struct OpenLine {};
/// Something may be transmitted: what already lies in the line's descriptor is to be handed in
/// first, then handle_looked() is to be called.
struct LookAtLine {};
struct TransmitFrame {
  FrameBytes frame;
};
struct JobEnded {
  Job* job;
  Ending ending;
};
/// Something was noticed of the line itself; framing_lost is told by CloseLine.
struct LineNotice {
  LineFault fault;
};
/// What comes in cannot be followed any further. The bus has given the line up already: nothing
/// needs to be reported back.
struct CloseLine {};
/// Nothing at all is heard from the adapter: it is to be closed and opened again. Jobs wait
/// meanwhile.
struct ReopenLine {
  Duration silence;
  unsigned requests;  ///< that left in this time
  bool first;         ///< since something was heard
};
/// The line was not silent for so long that nothing can be transmitted on it.
struct NeverSilent {};
/// A connection is given up, because nothing comes from its far end; OpenLine follows when somebody
/// waits for it. Nothing needs to be reported back.
struct ReplaceLine {
  bool is_news;  ///< something has come since this was told last
};
/// What was learned of the device at an address.
struct DeviceNotice {
  enum class Kind : std::uint8_t {
    lost,             ///< it does not answer: offline
    back,             ///< it answers again
    late,             ///< an answer came after its time, and the quarantine grew
    early,            ///< an answer began before its time: response_wait is set too long
    foreign,          ///< another client's request, or a frame of a device that owed none for long
    second_answer,    ///< two frames came for one request
    stop_unanswered,  ///< a stop was repeated as often as allowed, without a fitting echo
    stop_forced       ///< a stop was transmitted though the line was never silent
  };
  Kind kind;
  std::uint8_t address;
  Duration lateness{0};         ///< late: after the response timeout
  Duration quarantine{0};       ///< late: in force from now on
  bool answered_before = true;  ///< lost, back: has it ever sent a valid answer?
  unsigned requests = 0;        ///< lost: unanswered in a row
  bool is_request = false;      ///< foreign: it was a request
};
using BusAction = std::variant<OpenLine, LookAtLine, TransmitFrame, JobEnded, LineNotice, CloseLine,
                               ReopenLine, ReplaceLine, NeverSilent, DeviceNotice, QualityNotice>;

}  // namespace mbgate::bus
