// SPDX-License-Identifier: Apache-2.0
#include "ctl/visible_text.hpp"

#include <algorithm>
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

/// In characters, not in bytes.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(std::ranges::count_if(
      text, [](char byte) { return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U; }));
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

std::string columns(const std::vector<std::vector<std::string>>& rows, const ColumnStyle& style) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t i = 0; i < row.size(); ++i) {
      widths[i] = std::max(widths[i], width_of(row[i]));
    }
  }
  std::string text;
  for (std::size_t at = 0; at < rows.size(); ++at) {
    std::string line(style.indent);
    for (std::size_t i = 0; i < rows[at].size(); ++i) {
      const std::string& cell = rows[at][i];
      const std::string blanks(widths[i] - width_of(cell), ' ');
      line += (i == 0 ? "" : "  ") + (i < style.words ? cell + blanks : blanks + cell);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    text += line + "\n" + (at < style.below.size() ? style.below[at] : "");
  }
  return text;
}

}  // namespace mbgate::ctl
