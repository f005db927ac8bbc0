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
  std::size_t late = 0;        ///< among the answered
  std::size_t doubled = 0;     ///< answered twice, with nothing left unanswered before
  std::size_t echoes = 0;
  std::size_t most_bytes = 0;  ///< after one request, in place of its answer
  bool other_client = false;
  /// Of the answers, ascending; without those after an unanswered request, which may be its own.
  std::vector<std::chrono::nanoseconds> times{};

  [[nodiscard]] std::size_t damaged() const { return bad_crcs + noise; }
};

Tally tally_of(const UnitTrials& unit);

/// Has the unit fallen silent for good? Then it need not be asked again.
[[nodiscard]] bool is_given_up(const std::vector<Trial>& trials);

}  // namespace mbgate::ctl
