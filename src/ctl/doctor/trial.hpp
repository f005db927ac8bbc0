// SPDX-License-Identifier: Apache-2.0
// What came after one read: how many answers, when, an echo, frames of others.
#pragma once

#include <chrono>
#include <optional>
#include <vector>

#include "ctl/doctor/line_plan.hpp"
#include "ctl/serial/heard.hpp"
#include "ctl/serial/serial_client.hpp"

namespace mbgate::ctl {

struct Trial {
  HeardKind kind = HeardKind::silence;
  bool echo = false;            ///< the request itself came back first
  unsigned answers = 0;         ///< whole ones, of the unit to this read
  bool other_client = false;    ///< a request that was not ours
  std::uint8_t other_unit = 0;  ///< of HeardKind::other_frame
  std::size_t bytes = 0;        ///< without an echo
  std::optional<std::uint8_t> exception{};
  std::chrono::nanoseconds took{0};  ///< from the end of the request to the answer's first bytes
};

Trial understand(const SentRead& sent, const std::vector<Piece>& pieces);

/// All that one unit was asked.
struct UnitTrials {
  PlannedUnit unit;
  std::vector<Trial> trials{};
};

}  // namespace mbgate::ctl
