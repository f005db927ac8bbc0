// SPDX-License-Identifier: Apache-2.0
// What a framer makes of the bytes that it was given.
#pragma once

#include <cstddef>
#include <cstdint>

namespace mbgate::bus {

/// Stray frames of one piece of bytes whose addresses a framer keeps.
inline constexpr std::size_t kMostStrays = 16;

/// A good frame that answers nothing that was asked.
struct Stray {
  std::uint8_t address;
  bool is_response;  ///< it has the length of one; else it may be another client's request
};

enum class Verdict : std::uint8_t {
  none,      ///< nothing yet
  response,  ///< response() has it
  damaged    ///< a frame of the right unit, function and length, with a wrong CRC or LRC
};

}  // namespace mbgate::bus
