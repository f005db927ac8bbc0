// SPDX-License-Identifier: Apache-2.0
#include "ctl/visible_text.hpp"

#include <array>
#include <fmt/core.h>
#include <utility>

#include "base/utf8.hpp"

namespace mbgate::ctl {
namespace {

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
      visible += fmt::format("\\u{:04X}", std::uint32_t{code});
    }
    text.remove_prefix(size == 0 ? 1 : size);
  }
  return visible;
}

}  // namespace mbgate::ctl
