// SPDX-License-Identifier: Apache-2.0
// A configuration to start from, as a scan sees the bus. `mbgated --check` takes it as it is; what
// reading cannot tell stands in it as a comment to choose from, never as a guess: a wrong word
// order would move an axis somewhere else.
#pragma once

#include <string>

#include "ctl/scan/scan.hpp"

namespace mbgate::ctl {

/// `bus` is the name that the bus gets.
std::string starting_config(const Target& target, const std::string& bus,
                            const std::vector<FoundUnit>& found);

/// A response timeout with a good margin over the slowest answer that was seen: at least thrice as
/// long, at least 100 ms, a round figure.
std::chrono::milliseconds sensible_timeout(std::chrono::nanoseconds slowest);

}  // namespace mbgate::ctl
