// SPDX-License-Identifier: Apache-2.0
// SHA-256 (FIPS 180-4) of text, for what is shown and compared with sha256sum(1).
#pragma once

#include <span>
#include <string>
#include <string_view>

namespace mbgate::io {

/// Of the texts one behind the other: 64 hexadecimal digits in lower case.
std::string sha256(std::span<const std::string_view> texts);
std::string sha256(std::string_view text);

}  // namespace mbgate::io
