// SPDX-License-Identifier: Apache-2.0
// What the explorer's own reasoning rests on. If it does not hold, what was explored proves
// nothing.
#pragma once

#include <chrono>
#include <stdexcept>
#include <string>

#include "bus/instant.hpp"

namespace mbgate::explore {

/// No small world lives so long from its first request on; nothing that is older decides anything.
inline constexpr bus::Duration kLongestLife = std::chrono::seconds(50);
/// An instant that counts as long as anything does.
inline constexpr bus::Duration kFarPast = kLongestLife;

inline void require(bool holds, const char* what) {
  if (!holds) {
    throw std::logic_error(std::string("the explorer's reasoning does not hold: ") + what);
  }
}

}  // namespace mbgate::explore
