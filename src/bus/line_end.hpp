// SPDX-License-Identifier: Apache-2.0
// The reports of a line discipline to the bus above it: how transmissions ended, frames that answer
// no pending request, and faults of the line itself.
#pragma once

#include <algorithm>
#include <boost/container/static_vector.hpp>
#include <cstdint>
#include <optional>
#include <vector>

#include "bus/job.hpp"
#include "modbus/response.hpp"

namespace mbgate::bus {

/// As in Serial Line V1.02, figures 7 and 14.
enum class LineState : std::uint8_t {
  initial,  ///< listening after the line was opened
  idle,
  emission,
  waiting_for_reply,
  waiting_turnaround_delay,
  draining  ///< something other than a response was received, and the line is not silent yet
};

/// An earlier transmission to the same device, with the same function code, whose answer may still
/// come.
struct OwedAnswer {
  modbus::Request asked;
  bool is_own;           ///< an earlier try of the request: its answer is as good
  bool is_stop = false;  ///< but not an exception to an earlier stop, which may pass

  [[nodiscard]] bool is_own_answer(const modbus::Pdu& response) const {
    return is_own && !(is_stop && response.is_exception());
  }
};
/// Oldest first: a device works in order.
using OwedAnswers = std::vector<OwedAnswer>;
/// The one that the response belongs to.
inline OwedAnswers::iterator first_fit(OwedAnswers& owed, const modbus::Pdu& response) {
  return std::ranges::find_if(owed, [&](const OwedAnswer& it) {
    return is_fitting(modbus::check_response(it.asked, response.bytes()));
  });
}

/// Unsolicited frames of one piece of bytes that a framer keeps until they are taken.
inline constexpr std::size_t kMostUnsolicited = 16;

/// The verdict of a framer on the bytes that it was given.
enum class Verdict : std::uint8_t {
  none,      ///< nothing yet
  response,  ///< found() has it
  damaged    ///< a frame of the right unit, function and length, with a wrong CRC or LRC
};

/// The response that a framer has found. It lasts until the next call of expect() or again().
struct FoundResponse {
  std::optional<modbus::Pdu> pdu;
  /// When its first byte came. On a line that keeps its pace: when that began at the latest,
  /// because each of its bytes has taken its time on the wire, however they were read.
  Instant began;
  bool came_first = false;  ///< nothing at all came before it since expect()
  /// Bytes before it, or before the damaged frame, that were no part of it.
  std::size_t noise = 0;
};

/// How a transmission ended.
struct LineEnd {
  enum class How : std::uint8_t {
    response,     ///< the transaction has it
    sent,         ///< a broadcast has left the wire; the turnaround delay runs
    no_response,  ///< no response came in time
    damaged,      ///< a response with a wrong CRC or LRC
    misfit        ///< a good frame of the device that does not fit what was asked, and no other
  };
  How how;
  Transaction* transaction;
  Instant due{};       ///< when its response timeout ends, whether or not it was waited for
  Duration took{0};    ///< response: from the end of the request to the end of the answer
  bool early = false;  ///< a response that began clearly before the device's response wait was over
  std::size_t heard = 0;     ///< bytes received since the end of the request
  Duration heard_after{0};   ///< from the end of the request to the first of them
  std::size_t noise = 0;     ///< bytes before the response, good or damaged, that are no part of it
  bool may_be_echo = false;  ///< no response, but what may be one: it may be an echo as well
  bool shows_no_echo = false;  ///< a response that shows it: what may have been an echo was none
};

/// What was noticed of an echo that the settings say nothing of, or deny.
enum class NoticedEcho : std::uint8_t {
  none,
  unproven,  ///< a write came back unchanged, and that may be an echo
  found,
  denied  ///< found, and the settings say that there is none
};

enum class LineFault : std::uint8_t {
  echo_differed,  ///< the echo of an own transmission differs from it
  framing_lost,   ///< it cannot be known any more where the next frame begins
  echo_found,     ///< the line has an echo: from now on it is compared
  echo_gone,      ///< an echo was found before, but the last answers came without one
  echo_denied,    ///< the line has an echo, and the settings say that it has none
  /// The answer to a write looks like its echo, and it is not known yet whether the line has an
  /// echo.
  echo_unproven,
  /// A matching answer began before its request had left, and was not accepted.
  answered_while_sending,
  unanswered,  ///< a connection takes requests, and nothing has been received from it for long
  /// A response timeout has ended behind a part of an answer: where the next one begins is not
  /// known.
  answer_cut_off,
  driver_stalled  ///< the driver still holds bytes that should have left long ago
};
/// A valid frame that answers no pending request.
struct UnsolicitedFrame {
  std::uint8_t address;
  modbus::Pdu pdu;
  bool is_response;      ///< it has the length of a response
  bool is_request;       ///< it can only be a request
  bool after_noise;      ///< other bytes came before it: it may look like a frame only by chance
  bool is_echo = false;  ///< found to be the echo of the last read
  Instant came;          ///< when its last byte came; what it was may be known only later
  Duration pause{0};     ///< it was cut by a pause that is longer than frame_slack

  UnsolicitedFrame(std::uint8_t from, const modbus::Pdu& heard, Instant when, bool noisy = false)
      : address(from), pdu(heard), after_noise(noisy), came(when) {
    const modbus::PduLength whole{modbus::PduLength::Kind::known, pdu.size()};
    is_response = modbus::response_length(pdu.bytes()) == whole;
    is_request = !is_response && modbus::request_length(pdu.bytes()) == whole &&
                 modbus::Request::parse(pdu).has_value();
  }
};

/// What was noticed and is not told yet: `Most` of it; more is dropped.
template <typename Thing, std::size_t Most>
class Untold {
 public:
  void add(const Thing& thing) {
    if (things_.size() < Most) {
      things_.push_back(thing);
    }
  }
  /// Removes and returns the oldest; nothing if there is none.
  std::optional<Thing> take() {
    if (things_.empty()) {
      return std::nullopt;
    }
    Thing thing = things_.front();
    things_.erase(things_.begin());
    return thing;
  }
  void clear() { things_.clear(); }
  [[nodiscard]] bool empty() const { return things_.empty(); }

 private:
  boost::container::static_vector<Thing, Most> things_;
};
using LineFaults = Untold<LineFault, 8>;

}  // namespace mbgate::bus
