// SPDX-License-Identifier: Apache-2.0
#include "ctl/visible_text.hpp"

#include <array>
#include <bit>
#include <cstdio>
#include <utility>

namespace mbgate::ctl {
namespace {

struct Character {
  char32_t code;
  std::size_t size;  ///< in bytes; 0: they are no UTF-8
};

/// The first character (RFC 3629, 3 and 4). The text is not empty.
Character first_character(std::string_view text) {
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
  return is_valid ? Character{code, size} : Character{lead, 0};
}

bool controls(char32_t code) {
  constexpr std::array<std::pair<char32_t, char32_t>, 5> kRanges{
      {{0, 0x1F}, {0x7F, 0x9F}, {0x200E, 0x200F}, {0x2028, 0x202E}, {0x2066, 0x2069}}};
  for (const auto& [first, last] : kRanges) {
    if (code >= first && code <= last) {
      return true;
    }
  }
  return false;
}

}  // namespace

std::string visible_text(std::string_view text, std::string_view kept) {
  std::string visible;
  while (!text.empty()) {
    const auto [code, size] = first_character(text);
    const bool is_kept = kept.find(text.front()) != std::string_view::npos;
    if (size != 0 && (is_kept || !controls(code))) {
      visible += text.substr(0, size);
    } else {
      std::array<char, sizeof "\\u001B"> escaped{};
      std::snprintf(escaped.data(), escaped.size(), "\\u%04X", static_cast<unsigned>(code));
      visible += escaped.data();
    }
    text.remove_prefix(size == 0 ? 1 : size);
  }
  return visible;
}

}  // namespace mbgate::ctl
