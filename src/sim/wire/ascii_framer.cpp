// SPDX-License-Identifier: Apache-2.0
#include "sim/wire/ascii_framer.hpp"

#include <utility>

namespace mbgate::sim {

std::optional<AsciiFrame> AsciiFramer::feed(std::uint8_t character, bus::Instant begin,
                                            bus::Instant end) {
  std::optional<AsciiFrame> ended;
  const bool given_up = !frame_.bytes.empty() && (character == modbus::kAsciiStart ||
                                                  begin - frame_.end > kAsciiCharacterTimeout);
  if (given_up) {
    ended = std::exchange(frame_, {});
  }
  if (character == modbus::kAsciiStart) {
    frame_.begin = begin;
  } else if (frame_.bytes.empty()) {
    return ended;
  }
  frame_.bytes.push_back(character);
  frame_.end = end;
  if (character == modbus::kAsciiEnd || frame_.bytes.size() > modbus::kMaxAsciiSize) {
    ended = std::exchange(frame_, {});
  }
  return ended;
}

}  // namespace mbgate::sim
