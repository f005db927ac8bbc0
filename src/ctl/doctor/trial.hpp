// SPDX-License-Identifier: Apache-2.0
// What came after one read: how many answers, when, an echo, frames of others; and what came while
// nothing was asked.
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
  bool echo = false;            ///< the request itself came back
  unsigned answers = 0;         ///< whole ones, of the unit to this read
  std::string other_client{};   ///< a request that was not ours, in words; empty: none
  std::uint8_t other_unit = 0;  ///< of HeardKind::other_frame
  std::size_t bytes = 0;        ///< with an echo, behind it
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

}  // namespace mbgate::ctl
