// SPDX-License-Identifier: Apache-2.0
// Numbers that people and programs wrote.
#pragma once

#include <charconv>
#include <optional>
#include <string_view>
#include <system_error>

namespace mbgate {

/// The integer that is the whole of a text; nothing if there is more, or if it does not fit.
template <typename Integer>
std::optional<Integer> integer_in(std::string_view text, int base = 10) {
  Integer number{};
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number, base);
  return error == std::errc{} && at == end ? std::optional(number) : std::nullopt;
}

}  // namespace mbgate
