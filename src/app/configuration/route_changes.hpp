// SPDX-License-Identifier: Apache-2.0
// Which routes a reload changes, for the journal.
#pragma once

#include <string>
#include <vector>

#include "gateway/settings.hpp"

namespace mbgate::app {

/// A line for each route that differs, in the order of the new ones: "route of unit 11: device
/// axis-x -> device axis-y, access read-write -> read-only", "route of units 1..247 (listener
/// plant) added: bus line-a". The settings have the same numbering.
std::vector<std::string> route_changes(const gateway::Settings& old, const gateway::Settings& next);

}  // namespace mbgate::app
