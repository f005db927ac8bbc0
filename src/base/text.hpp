// SPDX-License-Identifier: Apache-2.0
// Numbers and lists in texts: written for people, and read from what people wrote.
#pragma once

#include <charconv>
#include <cstdint>
#include <fmt/core.h>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

namespace mbgate {

/// "1 stop", "2 stops".
inline std::string counted(std::uint64_t count, std::string_view one) {
  return fmt::format("{} {}{}", count, one, count == 1 ? "" : "s");
}

/// "1 bus", "2 buses".
inline std::string counted(std::uint64_t count, std::string_view one, std::string_view many) {
  return fmt::format("{} {}", count, count == 1 ? one : many);
}

/// The result of `text`, a function or a member, for each element, joined by `between`.
template <typename List, typename Text>
std::string joined(const List& list, Text text, std::string_view between = ", ") {
  std::string all;
  for (const auto& element : list) {
    all.append(all.empty() ? "" : between).append(std::invoke(text, element));
  }
  return all;
}

/// The integer that is the whole of a text; nothing if there is more, or if it does not fit.
template <typename Integer>
std::optional<Integer> integer_in(std::string_view text, int base = 10) {
  Integer number{};
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number, base);
  return error == std::errc{} && at == end ? std::optional(number) : std::nullopt;
}

}  // namespace mbgate
