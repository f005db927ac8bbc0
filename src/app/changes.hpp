// SPDX-License-Identifier: Apache-2.0
// What a reload changes, for the journal.
#pragma once

#include <string>
#include <vector>

#include "gateway/settings.hpp"

namespace mbgate::app {

/// What differs between two settings that have the same numbers (gateway/settings/numbering), a
/// line for each listener, bus and device: "bus line-a: baud 19200 -> 115200, parity". Nothing:
/// they are the same.
std::vector<std::string> changes_between(const gateway::Settings& old,
                                         const gateway::Settings& next);

}  // namespace mbgate::app
