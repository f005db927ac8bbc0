// SPDX-License-Identifier: Apache-2.0
// The words of the command line that say who is measured.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "subject.hpp"

namespace mbgate::bench {

/// "NAME=COMMAND" each. Throws std::invalid_argument.
std::map<std::string, std::string> parse_commands(const std::vector<std::string>& texts);

/// "NAME" or "NAME:key=value,key=value": what is not said is as in `common`. Throws
/// std::invalid_argument: what is wrong, and what would be right.
Scenario parse_contestant(const std::string& text, const Scenario& common,
                          const std::map<std::string, std::string>& commands);

}  // namespace mbgate::bench
