// SPDX-License-Identifier: Apache-2.0
// Finds ASCII frames among the characters on a line: from ':' to LF; another ':' begins anew, and a
// second of silence or too many characters end the attempt (Serial Line V1.02, 2.5.2 and figure
// 15). Characters between frames are noise. Pure: instants are handed in.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "bus/instant.hpp"
#include "modbus/ascii.hpp"

namespace mbgate::sim {

/// Longest silence between two characters of a frame.
inline constexpr bus::Duration kAsciiCharacterTimeout = std::chrono::seconds(1);

struct AsciiFrame {
  std::vector<std::uint8_t> bytes;
  bus::Instant begin;  ///< of its ':'
  bus::Instant end;    ///< of its last character
};

class AsciiFramer {
 public:
  /// Takes a character that was on the line from `begin` to `end`. Returns the frame that it ends:
  /// one that is complete with this LF, or one that is given up before it.
  std::optional<AsciiFrame> feed(std::uint8_t character, bus::Instant begin, bus::Instant end);
  void clear() { frame_.bytes.clear(); }

 private:
  AsciiFrame frame_;  ///< without bytes: none has begun
};

}  // namespace mbgate::sim
