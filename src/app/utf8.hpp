// SPDX-License-Identifier: Apache-2.0
// Makes UTF-8, which JSON requires, of any bytes, such as a path of the file system.
#pragma once

#include <string>
#include <string_view>

namespace mbgate::app {

/// The text, with U+FFFD in place of each byte that is no part of a valid character (RFC 3629).
std::string valid_utf8(std::string_view text);

}  // namespace mbgate::app
