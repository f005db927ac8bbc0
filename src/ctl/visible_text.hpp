// SPDX-License-Identifier: Apache-2.0
// What somebody else says, as it may be printed: a terminal obeys control characters, and a server
// could change its title with them, hide lines, or type into the shell.
#pragma once

#include <string>
#include <string_view>

namespace mbgate::ctl {

/// The text with control characters (C0, DEL, C1), those that turn the direction of writing, and
/// bytes that are no UTF-8 written as "\u001B". What was JSON is the same JSON then. Of the control
/// characters those in `kept` stay.
std::string visible_text(std::string_view text, std::string_view kept = {});

}  // namespace mbgate::ctl
