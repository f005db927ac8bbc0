// SPDX-License-Identifier: Apache-2.0
// What a framer makes of the bytes that it was given.
#pragma once

#include <cstddef>
#include <cstdint>

#include "bus/unsolicited.hpp"

namespace mbgate::bus {

/// UnsolicitedFrame frames of one piece of bytes whose addresses a framer keeps.
inline constexpr std::size_t kMostUnsolicited = 16;

enum class Verdict : std::uint8_t {
  none,      ///< nothing yet
  response,  ///< response() has it
  damaged    ///< a frame of the right unit, function and length, with a wrong CRC or LRC
};

}  // namespace mbgate::bus
