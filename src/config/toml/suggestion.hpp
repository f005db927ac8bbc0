// SPDX-License-Identifier: Apache-2.0
// Finds the known word that a misspelt one was probably meant to be, for "did you mean".
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace mbgate::config {

/// How many letters must be inserted, removed, replaced or swapped with their neighbour to turn one
/// word into the other (Damerau-Levenshtein distance, optimal string alignment).
std::size_t edit_distance(std::string_view from, std::string_view to);

/// The nearest candidate that is at most a third of the word's letters away, rounded, and never
/// more than 3.
std::optional<std::string_view> nearest(std::string_view word,
                                        const std::vector<std::string_view>& candidates);

/// "; did you mean 'response_timeout'?", or nothing.
std::string did_you_mean(std::string_view word, const std::vector<std::string_view>& candidates);

/// The same for a key; `known` are all keys of its table. The name that other programs use for a
/// key takes precedence over a similar spelling.
std::string did_you_mean_key(std::string_view key, const std::vector<std::string_view>& known);

}  // namespace mbgate::config
