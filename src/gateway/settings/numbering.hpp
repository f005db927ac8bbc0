// SPDX-License-Identifier: Apache-2.0
// Listeners, buses and devices are numbered once, by name. A number keeps its meaning, so that
// nothing stored under it can mean another thing after a reload.
#pragma once

#include <algorithm>

#include "gateway/settings.hpp"

namespace mbgate::gateway {

/// The settings `read`, with the numbers of those in force: the same name has the same number, what
/// is new gets an unused one, and what was removed keeps an empty entry (`is_gone`).
[[nodiscard]] Settings numbered_after(const Settings& in_force, Settings read);

/// How many of these listeners or buses are there: entries that a reload has emptied are none.
[[nodiscard]] std::size_t count_there(const auto& all) {
  return static_cast<std::size_t>(
      std::ranges::count_if(all, [](const auto& it) { return !it.is_gone; }));
}

/// Does the bus keep the same line?
[[nodiscard]] bool keeps_line(const Settings& old, const Settings& next, BusId bus);

}  // namespace mbgate::gateway
