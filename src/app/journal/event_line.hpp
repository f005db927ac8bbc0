// SPDX-License-Identifier: Apache-2.0
// An event of the machine as a line of the log: how important it is, and how often it is written.
#pragma once

#include "app/log.hpp"
#include "gateway/event.hpp"

namespace mbgate::app {

/// A notice is an ordinary event or a recovery; a warning is for somebody to look at.
Level level_of(const gateway::Event& event);

/// The names are taken from the settings. What the machine itself limits, or must not be left out,
/// is written however often it comes; the rest ten times a minute for each kind and place.
void write_event(Log& log, const gateway::Event& event, const gateway::Settings& settings);

}  // namespace mbgate::app
