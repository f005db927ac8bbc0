// SPDX-License-Identifier: Apache-2.0
// What a reload changes, for the journal.
#pragma once

#include <string>
#include <vector>

#include "gateway/settings.hpp"

namespace mbgate::app {

/// The differences between two settings with the same numbering
/// (gateway/settings/settings_snapshot), one line for each listener, bus, device and route: "bus
/// line-a: baud 19200 -> 115200". Empty if they are the same.
std::vector<std::string> changes_between(const gateway::Settings& old,
                                         const gateway::Settings& next);

// Which routes a reload changes, for the journal.

/// A line for each route that differs, in the order of the new ones: "route of unit 11: device
/// axis-x -> device axis-y, access read-write -> read-only", "route of units 1..247 (listener
/// plant) added: bus line-a". The settings have the same numbering.
std::vector<std::string> route_changes(const gateway::Settings& old, const gateway::Settings& next);

}  // namespace mbgate::app
