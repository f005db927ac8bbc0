// SPDX-License-Identifier: Apache-2.0
// Plays a recording (mbgated --record) to this version's own machine: the same inputs at the same
// instants must give the same actions, byte for byte.
#pragma once

#include <cstddef>
#include <filesystem>
#include <istream>
#include <optional>
#include <string>

namespace mbgate::ctl {

/// Where this version does something else than what was recorded.
struct ReplayDifference {
  std::size_t line = 0;  ///< of the recording; the first one is 1
  std::string input;     ///< the line of the last input before it; empty: there was none
  std::string recorded;  ///< the line of the action
  std::string replayed;  ///< what is done instead, as a line of a recording
};

/// Why the recording cannot be replayed.
struct BadRecording {
  std::size_t line = 0;
  std::string reason;  ///< what was expected, and what stands there
};

struct ReplayOutcome {
  std::string version;      ///< of the gateway that was recorded
  std::size_t inputs = 0;   ///< that were fed to the machine
  std::size_t actions = 0;  ///< that were the same
  std::string ended;        ///< why the recording ends before the gateway did; empty: it does not
  /// At most one of these; none: every action is the recorded one.
  std::optional<ReplayDifference> difference;
  std::optional<BadRecording> bad;
};

/// `profiles` goes before the folder that the recording names. Without either, profiles are looked
/// for as the gateway does. It ends at the first difference: what clients and devices would have
/// done after it, the recording cannot know.
ReplayOutcome replay(std::istream& recording,
                     const std::optional<std::filesystem::path>& profiles = std::nullopt);

}  // namespace mbgate::ctl
