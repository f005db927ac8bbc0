// SPDX-License-Identifier: Apache-2.0
// The topic of an event of the machine. Each kind of event has a MESSAGE_ID of its own; a kind
// without one does not compile.
#pragma once

#include "app/journal/journal.hpp"
#include "app/log.hpp"
#include "gateway/event.hpp"

namespace mbgate::app {

/// The names are taken from the settings.
Topic topic_of(const gateway::Event& event, const gateway::Settings& settings);

/// A notice is an ordinary event or a recovery; a warning is for somebody to look at.
Level level_of(const gateway::Event& event);

// An event of the machine as a line of the log, and how often it is written.

/// The names are taken from the settings. What the machine itself limits, or must not be left out,
/// is written however often it comes; the rest ten times a minute for each kind and place.
void write_event(Log& log, const gateway::Event& event, const gateway::Settings& settings);

}  // namespace mbgate::app
