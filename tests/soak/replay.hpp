// SPDX-License-Identifier: Apache-2.0
// A recording (mbgated --record) played to the product's own machine: the same inputs at the same
// instants must give the same actions, byte for byte.
#pragma once

#include <cstddef>
#include <filesystem>
#include <istream>
#include <optional>
#include <string>

namespace mbgate::test {

struct ReplayOutcome {
  std::string version;  ///< of the gateway that was recorded
  std::size_t inputs = 0;
  std::size_t actions = 0;
  std::string ended;  ///< why the recording ends before the gateway did; empty: it does not
  /// The first difference, or what is wrong with the recording, with its line; empty: identical.
  std::string difference;
};

/// `profiles` goes before the folder that the recording names. Without either, profiles are looked
/// for as the gateway does.
ReplayOutcome replay(std::istream& recording,
                     const std::optional<std::filesystem::path>& profiles = std::nullopt);

/// A summary in one line, or where the difference is.
std::string to_text(const ReplayOutcome& outcome);

}  // namespace mbgate::test
