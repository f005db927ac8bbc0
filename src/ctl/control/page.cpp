// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <fmt/core.h>

#include "ctl/control/status_text.hpp"

namespace mbgate::ctl {
namespace {

bool is_first_byte(char byte) {
  return (static_cast<unsigned char>(byte) & 0xC0U) != 0x80U;  // UTF-8, RFC 3629
}

bool moves_cursor(char byte) { return static_cast<unsigned char>(byte) < 0x20U || byte == '\x7F'; }

/// How many bytes the first `columns` characters have.
std::size_t bytes_of(std::string_view line, std::size_t columns) {
  std::size_t at = 0;
  for (std::size_t characters = 0; at < line.size(); ++at) {
    if (is_first_byte(line[at]) && ++characters > columns) {
      break;
    }
  }
  return at;
}

std::size_t indent_of(std::string_view line) {
  return std::min(line.find_first_not_of(' '), line.size());
}

bool is_row_of_table(std::string_view line) {
  return line.find("  ", indent_of(line)) != std::string_view::npos;
}

/// Ends lines at a blank; a word that is longer than a line is cut in two.
void fold(std::string line, std::size_t columns, std::vector<std::string>& lines) {
  constexpr std::size_t kFurther = 2;
  const std::size_t further = indent_of(line) + kFurther;
  const std::string indent(further < columns / 2 ? further : 0, ' ');
  while (true) {
    const std::size_t fits = bytes_of(line, columns);
    if (fits == line.size()) {
      lines.push_back(line);
      return;
    }
    const std::size_t blank = line.rfind(' ', fits);
    const bool is_after_word = blank != std::string::npos && blank > indent_of(line);
    const std::size_t end = is_after_word ? blank : fits;
    lines.push_back(line.substr(0, end));
    line.replace(0, is_after_word ? end + 1 : end, indent);
  }
}

}  // namespace

std::vector<std::string> page(std::string_view text, std::size_t rows, std::size_t columns) {
  std::vector<std::string> lines;
  if (rows == 0 || columns == 0) {
    return lines;
  }
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string line(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
    std::ranges::replace_if(line, moves_cursor, '?');
    if (is_row_of_table(line)) {
      lines.push_back(line.substr(0, bytes_of(line, columns)));
    } else {
      fold(std::move(line), columns, lines);
    }
  }
  if (lines.size() > rows) {
    const std::size_t hidden = lines.size() - rows + 1;
    const std::string note =
        fmt::format("... {} more lines: the window is too small for them", hidden);
    lines.resize(rows);
    lines.back() = note.substr(0, columns);
  }
  return lines;
}

}  // namespace mbgate::ctl
