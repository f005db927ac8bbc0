// SPDX-License-Identifier: Apache-2.0
#include "ctl/serial/line_mode.hpp"

#include <algorithm>
#include <charconv>
#include <iterator>
#include <optional>

namespace mbgate::ctl {
namespace {

using modbus::Parity;

constexpr std::uint32_t kFastestLine = 4'000'000;  // no UART of Linux has a faster one

std::vector<std::string_view> listed(std::string_view text) {
  std::vector<std::string_view> words;
  while (true) {
    const auto comma = text.find(',');
    words.push_back(text.substr(0, comma));
    if (comma == std::string_view::npos) {
      return words;
    }
    text.remove_prefix(comma + 1);
  }
}

std::optional<std::uint32_t> number_of(std::string_view text, std::uint32_t most) {
  std::uint32_t number = 0;
  const char* end = text.data() + text.size();
  const auto [at, error] = std::from_chars(text.data(), end, number);
  const bool good = error == std::errc{} && at == end && number >= 1 && number <= most;
  return good ? std::optional(number) : std::nullopt;
}

std::optional<Parity> parity_of(std::string_view word) {
  for (const auto parity : {Parity::even, Parity::none, Parity::odd}) {
    if (parity_word(parity) == word) {
      return parity;
    }
  }
  return std::nullopt;
}

/// All formats of one parity.
std::vector<modbus::CharacterFormat> formats(Parity parity,
                                             const std::vector<unsigned>& stop_bits) {
  if (parity != Parity::none) {
    return {{8, parity, 1}};
  }
  std::vector<modbus::CharacterFormat> result;
  result.reserve(stop_bits.size());
  for (const auto bits : stop_bits) {
    result.push_back({8, parity, bits});
  }
  return result;
}

}  // namespace

std::string mode_text(const LineMode& mode) {
  std::string text = std::to_string(static_cast<std::uint32_t>(mode.baud)) + " 8";
  switch (mode.format.parity) {
    case Parity::none: text += 'N'; break;
    case Parity::even: text += 'E'; break;
    case Parity::odd: text += 'O'; break;
  }
  return text + std::to_string(mode.format.stop_bits);
}

std::string_view parity_word(Parity parity) {
  switch (parity) {
    case Parity::none: return "none";
    case Parity::even: return "even";
    case Parity::odd: return "odd";
  }
  return {};
}

Result<std::vector<LineMode>, std::string> parse_modes(std::string_view bauds,
                                                       std::string_view parities,
                                                       std::string_view stop_bits) {
  std::vector<unsigned> stops;
  for (const auto word : listed(stop_bits)) {
    const auto bits = number_of(word, 2);
    if (!bits) {
      return "\"" + std::string(stop_bits) + "\" are no stop bits: 1, 2 or 1,2";
    }
    stops.push_back(*bits);
  }
  std::vector<modbus::CharacterFormat> characters;
  for (const auto word : listed(parities)) {
    const auto parity = parity_of(word);
    if (!parity) {
      return "\"" + std::string(parities) + "\" are no parities: even, none, odd, with commas";
    }
    std::ranges::copy(formats(*parity, stops), std::back_inserter(characters));
  }
  std::vector<LineMode> modes;
  for (const auto word : listed(bauds)) {
    const auto baud = number_of(word, kFastestLine);
    if (!baud) {
      return "\"" + std::string(bauds) +
             "\" are no baud rates: 1 to 4000000, with commas, like 9600,19200";
    }
    for (const auto& format : characters) {
      // What is listed twice is asked once.
      if (const LineMode mode{modbus::Baud{*baud}, format};
          std::ranges::find(modes, mode) == modes.end()) {
        modes.push_back(mode);
      }
    }
  }
  return modes;
}

}  // namespace mbgate::ctl
