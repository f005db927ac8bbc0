// SPDX-License-Identifier: Apache-2.0
// The trials of one unit, counted.
#pragma once

#include <chrono>
#include <vector>

#include "ctl/doctor/trial.hpp"

namespace mbgate::ctl {

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

/// How long a unit is listened to for an answer. Those that the gateway does not wait for are heard
/// too.
std::chrono::nanoseconds answer_wait(const PlannedUnit& unit);

/// How many answers to these may still come.
std::size_t owed_answers(const std::vector<Trial>& trials);

/// Has the unit fallen silent for good, or was it never understood? Then it need not be asked
/// again.
[[nodiscard]] bool is_given_up(const std::vector<Trial>& trials);

}  // namespace mbgate::ctl
