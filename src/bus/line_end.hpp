// SPDX-License-Identifier: Apache-2.0
// What a line discipline tells the bus above it: how transmissions ended, and what is wrong with
// the line itself.
#pragma once

#include <cstdint>
#include <string_view>

#include "bus/job.hpp"

namespace mbgate::bus {

/// As in Serial Line V1.02, figures 7 and 14.
enum class LineState : std::uint8_t {
  initial,  ///< listening after the line was opened
  idle,
  emission,
  waiting_for_reply,
  waiting_turnaround_delay,
  draining  ///< something else was heard than a response, and the line is not silent yet
};

/// The state's name for status displays.
std::string_view to_text(LineState state);

/// How a transmission ended.
struct LineEnd {
  enum class How : std::uint8_t {
    response,     ///< the transaction has it
    sent,         ///< a broadcast has left the wire; the turnaround delay runs
    no_response,  ///< the time for a response is over
    damaged       ///< a response with a wrong CRC or LRC
  };
  How how;
  Transaction* transaction;
  Instant due{};       ///< when its response timeout ends, whether or not it was waited for
  bool early = false;  ///< a response that began clearly before the device's response wait was over
};

enum class LineFault : std::uint8_t {
  echo_differed,  ///< an own transmission was heard differently than it was sent
  framing_lost    ///< where the next frame begins cannot be known any more
};

}  // namespace mbgate::bus
