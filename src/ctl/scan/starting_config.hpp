// SPDX-License-Identifier: Apache-2.0
// A configuration to start from, for the bus as a scan found it. `mbgated --check` accepts it as it
// is. What reading cannot show is left as a comment to choose from, never guessed: with a wrong
// word order an axis would move to another position.
#pragma once

#include <optional>
#include <string>

#include "ctl/scan/scan.hpp"

namespace mbgate::ctl {

/// A serial port, and the mode in which its units answered.
struct FoundLine {
  std::string device;
  std::optional<std::string> lasting_name{};  ///< another path to it, in /dev/serial/by-id
  LineMode mode{};
};

/// `bus` is the name that the bus gets.
std::string starting_config(const Target& target, const std::string& bus,
                            const std::vector<FoundUnit>& found);
std::string starting_config(const FoundLine& line, const std::string& bus,
                            const std::vector<FoundUnit>& found);

/// A response timeout with a good margin over the slowest answer that was seen: at least three
/// times as long, at least 100 ms, rounded.
std::chrono::milliseconds sensible_timeout(std::chrono::nanoseconds slowest);

}  // namespace mbgate::ctl
