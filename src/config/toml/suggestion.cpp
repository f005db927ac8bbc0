// SPDX-License-Identifier: Apache-2.0
#include "config/toml/suggestion.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <fmt/core.h>

namespace mbgate::config {
namespace {

constexpr std::size_t kMostEdits = 3;
/// No key or name is longer; keeps the work small for whatever stands in a file.
constexpr std::size_t kLongestWord = 64;

/// A key as other programs and people call it.
struct Familiar {
  std::string_view word;
  std::string_view ours;
  std::string_view beside;  ///< a key that the table must have too, so that it is the one meant
};

/// The first that fits counts. An `address` is an interface beside `port`, and a drive's beside
/// `profile`.
constexpr std::array kFamiliar = {
    Familiar{"baudrate", "baud", ""},
    Familiar{"baud_rate", "baud", ""},
    Familiar{"bitrate", "baud", ""},
    Familiar{"speed", "baud", ""},
    Familiar{"bits", "data_bits", ""},
    Familiar{"bytesize", "data_bits", ""},
    Familiar{"stopbits", "stop_bits", ""},
    Familiar{"timeout", "response_timeout", ""},
    Familiar{"timeout", "deadline", ""},
    Familiar{"timeout", "idle_timeout", ""},
    Familiar{"host", "address", "port"},
    Familiar{"hostname", "address", "port"},
    Familiar{"ip", "address", "port"},
    Familiar{"bind", "address", "port"},
    Familiar{"listen", "address", "port"},
    Familiar{"interface", "address", "port"},
    Familiar{"slave", "unit", ""},
    Familiar{"slave", "address", "profile"},
    Familiar{"slave", "device", "route"},
    Familiar{"slave_id", "unit", ""},
    Familiar{"slave_id", "address", "profile"},
    Familiar{"slave_address", "address", "profile"},
    Familiar{"unit_id", "unit", ""},
    Familiar{"unit_id", "address", "profile"},
    Familiar{"unit", "address", "profile"},
    Familiar{"id", "unit", ""},
    Familiar{"id", "address", "profile"},
    Familiar{"station", "address", "profile"},
    Familiar{"node", "address", "profile"},
    Familiar{"type", "profile", ""},
    Familiar{"model", "profile", ""},
    Familiar{"type", "mode", ""},
    Familiar{"protocol", "mode", ""},
    Familiar{"framing", "mode", ""},
    Familiar{"tty", "device", "baud"},
    Familiar{"serial", "device", "baud"},
    Familiar{"serial_port", "device", "baud"},
    Familiar{"path", "device", "baud"},
    Familiar{"tty", "bus", "route"},
    Familiar{"serial", "bus", "route"},
    Familiar{"line", "bus", "route"},
    Familiar{"byte_order", "word_order", ""},
    Familiar{"byteorder", "word_order", ""},
    Familiar{"byte_swap", "word_order", ""},
    Familiar{"word_swap", "word_order", ""},
    Familiar{"swap", "word_order", ""},
    Familiar{"endian", "word_order", ""},
    Familiar{"endianness", "word_order", ""},
    Familiar{"read_only", "access", ""},
    Familiar{"readonly", "access", ""},
    Familiar{"max_clients", "max_connections", ""},
    Familiar{"cert", "certificate", ""},
    Familiar{"cert_file", "certificate", ""},
    Familiar{"key_file", "key", "authorities"},
    Familiar{"private_key", "key", "authorities"},
    Familiar{"ca", "authorities", ""},
    Familiar{"ca_file", "authorities", ""},
    Familiar{"cafile", "authorities", ""},
    Familiar{"max_connections_per_client", "max_connections_per_address", ""},
    Familiar{"max_connections_per_ip", "max_connections_per_address", ""},
};

/// "Baud-Rate" is "baud_rate".
std::string in_our_letters(std::string_view key) {
  std::string ours(key);
  for (char& letter : ours) {
    letter =
        letter == '-' ? '_' : static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
  }
  return ours;
}

std::string suggest(std::string_view word) { return fmt::format("; did you mean '{}'?", word); }

}  // namespace

std::size_t edit_distance(std::string_view from, std::string_view to) {
  // Rows of the distance table: two above, one above, and the one being filled.
  std::vector<std::size_t> before(to.size() + 1);
  std::vector<std::size_t> above(to.size() + 1);
  std::vector<std::size_t> row(to.size() + 1);
  for (std::size_t j = 0; j <= to.size(); ++j) {
    row[j] = j;
  }
  for (std::size_t i = 1; i <= from.size(); ++i) {
    std::swap(before, above);
    std::swap(above, row);
    row[0] = i;
    for (std::size_t j = 1; j <= to.size(); ++j) {
      const std::size_t replaced = above[j - 1] + (from[i - 1] == to[j - 1] ? 0 : 1);
      row[j] = std::min({above[j] + 1, row[j - 1] + 1, replaced});
      if (i > 1 && j > 1 && from[i - 1] == to[j - 2] && from[i - 2] == to[j - 1]) {
        row[j] = std::min(row[j], before[j - 2] + 1);
      }
    }
  }
  return row[to.size()];
}

std::optional<std::string_view> nearest(std::string_view word,
                                        const std::vector<std::string_view>& candidates) {
  if (word.size() > kLongestWord) {
    return std::nullopt;
  }
  std::optional<std::string_view> best;
  std::size_t best_distance = std::min(kMostEdits, (word.size() + 1) / 3) + 1;
  for (const auto candidate : candidates) {
    if (candidate.size() > kLongestWord || candidate.empty()) {
      continue;
    }
    const std::size_t distance = edit_distance(word, candidate);
    if (distance < best_distance) {
      best_distance = distance;
      best = candidate;
    }
  }
  return best;
}

std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& candidates) {
  const auto best = nearest(word, candidates);
  return best ? suggest(*best) : std::string();
}

std::string did_you_mean_key(std::string_view key, const std::vector<std::string_view>& known) {
  const auto has = [&](std::string_view wanted) {
    return std::ranges::find(known, wanted) != known.end();
  };
  const std::string word = in_our_letters(key);
  const auto familiar = std::ranges::find_if(kFamiliar, [&](const Familiar& entry) {
    return entry.word == word && has(entry.ours) && (entry.beside.empty() || has(entry.beside));
  });
  return familiar != kFamiliar.end() ? suggest(familiar->ours) : did_you_mean(key, known);
}

}  // namespace mbgate::config
