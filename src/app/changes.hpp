// SPDX-License-Identifier: Apache-2.0
// What a reload changes, for the journal.
#pragma once

#include <string>
#include <vector>

#include "gateway/settings.hpp"

namespace mbgate::app {

/// The differences between two settings with the same numbering (gateway/settings/numbering), one
/// line for each listener, bus, device and route: "bus line-a: baud 19200 -> 115200, parity". Empty
/// if they are the same.
std::vector<std::string> changes_between(const gateway::Settings& old,
                                         const gateway::Settings& next);

}  // namespace mbgate::app
