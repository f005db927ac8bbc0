// SPDX-License-Identifier: Apache-2.0
// Reads UTF-8 (RFC 3629), which has no overlong characters, no surrogates, none beyond U+10FFFF.
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <string_view>

namespace mbgate {

struct Utf8Character {
  char32_t code;
  std::size_t size;  ///< in bytes; 0: they are no UTF-8, and `code` is the first of them
};

/// The first character. The text is not empty.
inline Utf8Character first_character(std::string_view text) {
  const auto lead = static_cast<unsigned char>(text.front());
  const auto size = static_cast<std::size_t>(std::countl_one(lead));
  if (size == 0) {
    return {lead, 1};
  }
  constexpr std::array<char32_t, 5> kSmallest{0, 0, 0x80, 0x800, 0x10000};  // by their size
  if (size == 1 || size >= kSmallest.size() || size > text.size()) {
    return {lead, 0};
  }
  char32_t code = lead & (0x7FU >> size);
  for (const char byte : text.substr(1, size - 1)) {
    const auto further = static_cast<unsigned char>(byte);
    if (std::countl_one(further) != 1) {
      return {lead, 0};
    }
    code = code << 6U | (further & 0x3FU);
  }
  const bool is_surrogate = code >= 0xD800 && code <= 0xDFFF;
  const bool is_valid = code >= kSmallest[size] && code <= 0x10FFFF && !is_surrogate;
  return is_valid ? Utf8Character{code, size} : Utf8Character{lead, 0};
}

}  // namespace mbgate
