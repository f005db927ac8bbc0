// SPDX-License-Identifier: Apache-2.0
// The result of one read: the number and times of answers, an echo, frames of others; and bytes
// that came while no request was open.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "ctl/doctor/line_plan.hpp"
#include "ctl/serial/heard.hpp"
#include "ctl/serial/serial_client.hpp"

namespace mbgate::ctl {

/// What came when nothing was asked.
struct Unasked {
  unsigned late_answers = 0;   ///< of the unit that was asked last
  std::size_t bytes = 0;       ///< that are no frame of ours and no answer to one
  std::string other_client{};  ///< a request that was not ours, in words; empty: none
  /// May it be another client? A few bytes are of no importance.
  [[nodiscard]] bool is_foreign() const;
};

struct Trial {
  HeardKind kind = HeardKind::silence;
  bool echo = false;           ///< the request itself came back
  unsigned answers = 0;        ///< whole ones, of the unit to this read
  std::string other_client{};  ///< a request that was not ours, in words; empty: none
  std::size_t bytes = 0;       ///< with an echo, behind it
  std::optional<std::uint8_t> exception{};
  std::chrono::nanoseconds took{0};  ///< from the end of the request to the answer's first bytes
  Unasked after{};                   ///< what came before the next request was sent
  bool settled = false;              ///< it was waited for so long that no answer is owed any more
};

Trial understand(const SentRead& sent, const std::vector<Piece>& pieces);

/// `asked`: the units that were asked this `read`, in their order.
Unasked understand_unasked(const modbus::TableRange& read, const std::vector<std::uint8_t>& asked,
                           modbus::Bytes heard);

/// All that one unit was asked.
struct UnitTrials {
  PlannedUnit unit;
  std::vector<Trial> trials{};
};

/// What came of the trials of one unit.
struct Tally {
  std::size_t asked = 0;
  std::size_t answered = 0;
  std::size_t silent = 0;
  std::size_t bad_crcs = 0;
  std::size_t noise = 0;
  std::size_t others = 0;      ///< another frame in place of the answer
  std::size_t exceptions = 0;  ///< among the answered
  std::size_t late = 0;        ///< among those with a time
  std::size_t overdue = 0;     ///< answers that came after their request was given up
  std::size_t doubled = 0;     ///< answered twice, while no earlier answer was owed
  std::size_t echoes = 0;
  std::size_t most_bytes = 0;  ///< after one request, in place of its answer
  bool other_client = false;   ///< a request that was not ours was heard
  bool disturbed = false;      ///< that, or bytes that may be of one
  /// Of the answers, ascending; without those that came while an earlier one was owed: they may be
  /// that one.
  std::vector<std::chrono::nanoseconds> times{};

  [[nodiscard]] std::size_t damaged() const { return bad_crcs + noise; }
};

Tally tally_of(const UnitTrials& unit);
std::vector<Tally> tallies_of(const std::vector<UnitTrials>& units);

/// Of all units together; only what is asked of a line is counted.
Tally tally_of_line(const std::vector<Tally>& tallies);

/// How long a unit is listened to for an answer. Those that the gateway does not wait for are heard
/// too.
std::chrono::nanoseconds answer_wait(const PlannedUnit& unit);

/// How many answers to these may still come.
std::size_t owed_answers(const std::vector<Trial>& trials);

/// Has the unit fallen silent for good, or was it never understood? Then it need not be asked
/// again.
[[nodiscard]] bool is_given_up(const std::vector<Trial>& trials);

}  // namespace mbgate::ctl
