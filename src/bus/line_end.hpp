// SPDX-License-Identifier: Apache-2.0
// What a line discipline tells the bus above it: how transmissions ended, and what is wrong with
// the line itself.
#pragma once

#include <boost/container/static_vector.hpp>
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

/// Answers of a device to earlier requests of the same function that may still come.
struct OwedAnswers {
  unsigned count = 0;
  unsigned alike = 0;  ///< of these, those that look as if a write were done that may not be
};

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
  Duration took{0};    ///< response: from the end of the request to the end of the answer
  bool early = false;  ///< a response that began clearly before the device's response wait was over
  std::size_t heard = 0;    ///< bytes that came since the request had left
  Duration heard_after{0};  ///< and how long after it the first of them
  std::size_t noise = 0;  ///< bytes before the response, or the damaged one, that are no part of it
};

enum class LineFault : std::uint8_t {
  echo_differed,  ///< an own transmission was heard differently than it was sent
  framing_lost,   ///< where the next frame begins cannot be known any more
  echo_found,     ///< the line hears itself: from now on echoes are compared
  echo_gone,      ///< it was found, and none has come with the last answers
  echo_denied,    ///< the line hears itself, and the settings say that it does not
  /// The answer to a write looks like its echo, and nothing has shown yet whether there is one.
  echo_unproven,
  /// A fitting answer began before its request had left, and was not taken.
  answered_while_sending,
  unanswered  ///< a connection takes requests, and for long nothing has come from it
};
/// Those that were noticed and not told yet.
using LineFaults = boost::container::static_vector<LineFault, 8>;
/// Forgotten if there is no room for it.
inline void note_fault(LineFaults& faults, LineFault fault) {
  if (faults.size() < faults.capacity()) {
    faults.push_back(fault);
  }
}

}  // namespace mbgate::bus
