// SPDX-License-Identifier: Apache-2.0
// The verdict of a framer on the bytes that it was given.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "bus/instant.hpp"
#include "bus/unsolicited.hpp"
#include "modbus/pdu.hpp"

namespace mbgate::bus {

/// Unsolicited frames of one piece of bytes that a framer keeps until they are taken.
inline constexpr std::size_t kMostUnsolicited = 16;

enum class Verdict : std::uint8_t {
  none,      ///< nothing yet
  response,  ///< found() has it
  damaged    ///< a frame of the right unit, function and length, with a wrong CRC or LRC
};

/// The response that a framer has found. It lasts until the next call of expect() or again().
struct FoundResponse {
  std::optional<modbus::Pdu> pdu;
  /// When its first byte came. On a line that keeps its pace: when that began at the latest,
  /// because each of its bytes has taken its time on the wire, however they were read.
  Instant began;
  bool came_first = false;  ///< nothing at all came before it since expect()
};

}  // namespace mbgate::bus
