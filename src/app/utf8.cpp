// SPDX-License-Identifier: Apache-2.0
#include "app/utf8.hpp"

#include <cstddef>
#include <cstdint>

namespace mbgate::app {
namespace {

std::uint8_t byte_at(std::string_view text, std::size_t at) {
  return at < text.size() ? static_cast<std::uint8_t>(text[at]) : std::uint8_t{0};
}

bool is_within(std::uint8_t byte, std::uint8_t first, std::uint8_t last) {
  return byte >= first && byte <= last;
}

// RFC 3629, section 4: the length by the first byte, and what the second may be.
std::size_t length_at(std::string_view text, std::size_t at) {
  const std::uint8_t first = byte_at(text, at);
  const std::uint8_t second = byte_at(text, at + 1);
  const bool third = is_within(byte_at(text, at + 2), 0x80, 0xBF);
  const bool fourth = is_within(byte_at(text, at + 3), 0x80, 0xBF);
  if (first < 0x80) {
    return 1;
  }
  if (is_within(first, 0xC2, 0xDF)) {
    return is_within(second, 0x80, 0xBF) ? 2 : 0;
  }
  if (is_within(first, 0xE0, 0xEF)) {
    const std::uint8_t least = first == 0xE0 ? 0xA0 : 0x80;
    const std::uint8_t most = first == 0xED ? 0x9F : 0xBF;
    return is_within(second, least, most) && third ? 3 : 0;
  }
  if (is_within(first, 0xF0, 0xF4)) {
    const std::uint8_t least = first == 0xF0 ? 0x90 : 0x80;
    const std::uint8_t most = first == 0xF4 ? 0x8F : 0xBF;
    return is_within(second, least, most) && third && fourth ? 4 : 0;
  }
  return 0;
}

}  // namespace

std::string valid_utf8(std::string_view text) {
  std::string valid;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t length = length_at(text, at);
    if (length == 0) {
      valid += "\xEF\xBF\xBD";
      ++at;
    } else {
      valid += text.substr(at, length);
      at += length;
    }
  }
  return valid;
}

}  // namespace mbgate::app
