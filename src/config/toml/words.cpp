// SPDX-License-Identifier: Apache-2.0
#include "config/toml/words.hpp"

#include <charconv>

namespace mbgate::config {

std::optional<std::uint16_t> parse_register_address(std::string_view text) {
  const bool is_hexadecimal = text.starts_with("0x");
  if (is_hexadecimal) {
    text.remove_prefix(2);
  }
  std::uint16_t address = 0;
  const char* const end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, address, is_hexadecimal ? 16 : 10);
  return error == std::errc{} && at == end ? std::optional(address) : std::nullopt;
}

}  // namespace mbgate::config
