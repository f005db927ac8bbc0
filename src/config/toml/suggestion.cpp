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

/// What other programs and people call a key.
struct Familiar {
  std::string_view ours;
  std::string_view beside;  ///< a key that the table must have too, so that it is the one meant
  std::string_view words;   ///< with blanks between and around them
};

/// The first that fits counts. An `address` is an interface beside `port`, and a drive's beside
/// `profile`.
constexpr std::array kFamiliar = {
    Familiar{"baud", "", " baudrate baud_rate bitrate speed "},
    Familiar{"data_bits", "", " bits bytesize "},
    Familiar{"stop_bits", "", " stopbits "},
    Familiar{"response_timeout", "", " timeout "},
    Familiar{"deadline", "", " timeout "},
    Familiar{"idle_timeout", "", " timeout "},
    Familiar{"address", "port", " host hostname ip bind listen interface "},
    Familiar{"unit", "", " slave slave_id unit_id id "},
    Familiar{"address", "profile", " slave slave_id slave_address unit_id unit id station node "},
    Familiar{"device", "route", " slave "},
    Familiar{"profile", "", " type model "},
    Familiar{"mode", "", " type protocol framing "},
    Familiar{"device", "baud", " tty serial serial_port path "},
    Familiar{"bus", "route", " tty serial line "},
    Familiar{"word_order", "", " byte_order byteorder byte_swap word_swap swap endian endianness "},
    Familiar{"access", "", " read_only readonly "},
    Familiar{"max_connections", "", " max_clients "},
    Familiar{"certificate", "", " cert cert_file "},
    Familiar{"key", "authorities", " key_file private_key "},
    Familiar{"authorities", "", " ca ca_file cafile "},
    Familiar{"max_connections_per_address", "",
             " max_connections_per_client max_connections_per_ip "},
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
  const std::string word = fmt::format(" {} ", in_our_letters(key));
  const auto familiar = std::ranges::find_if(kFamiliar, [&](const Familiar& entry) {
    return entry.words.find(word) != entry.words.npos && has(entry.ours) &&
           (entry.beside.empty() || has(entry.beside));
  });
  return familiar != kFamiliar.end() ? suggest(familiar->ours) : did_you_mean(key, known);
}

}  // namespace mbgate::config
