// SPDX-License-Identifier: Apache-2.0
// Makes text from elsewhere safe to print: a terminal obeys control characters, and a server could
// use them to change its title, hide lines, or type into the shell.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace mbgate::ctl {

/// The text with control characters (C0, DEL, C1), those that turn the direction of writing, and
/// bytes that are no UTF-8 written as "\u001B". What was JSON is the same JSON then. Of the control
/// characters those in `kept` stay.
std::string visible_text(std::string_view text, std::string_view kept = {});

struct ColumnStyle {
  std::string_view indent = "  ";
  std::size_t words = static_cast<std::size_t>(-1);  ///< the columns behind them are numbers
  std::span<const std::string> below = {};           ///< lines that follow each row
};
/// Rows of cells in columns, each as wide as its widest cell, two spaces between them. Words stand
/// at the left and numbers at the right; no line ends with a space.
std::string columns(const std::vector<std::vector<std::string>>& rows,
                    const ColumnStyle& style = {});

}  // namespace mbgate::ctl
