// SPDX-License-Identifier: Apache-2.0
// Bytes as tests write and compare them: "01 03 00 1E".
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "modbus/describe.hpp"

namespace mbgate::test {

/// The bytes of hexadecimal digits; everything else in the text is decoration.
inline std::vector<std::uint8_t> unhex(std::string_view text) {
  std::vector<std::uint8_t> bytes;
  unsigned value = 0;
  bool half = false;
  for (const char character : text) {
    const auto digit = std::string_view("0123456789ABCDEF").find(character);
    if (digit == std::string_view::npos) {
      continue;
    }
    value = value * 16 + static_cast<unsigned>(digit);
    if (half) {
      bytes.push_back(static_cast<std::uint8_t>(value));
      value = 0;
    }
    half = !half;
  }
  return bytes;
}

using modbus::hex;

}  // namespace mbgate::test
