// SPDX-License-Identifier: Apache-2.0
// Numbers in texts for people.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

namespace mbgate {

/// "1 stop", "2 stops".
inline std::string counted(std::uint64_t count, std::string_view one) {
  return std::to_string(count).append(" ").append(one).append(count == 1 ? "" : "s");
}

/// So many hexadecimal digits or more, in capitals.
inline std::string hex_text(std::uint64_t number, std::size_t digits) {
  std::string text;
  for (; number != 0 || text.size() < digits; number >>= 4U) {
    text.insert(text.begin(), "0123456789ABCDEF"[number & 0xFU]);
  }
  return text;
}

}  // namespace mbgate
