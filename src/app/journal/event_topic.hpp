// SPDX-License-Identifier: Apache-2.0
// What an event of the machine is about. Each kind of event has a MESSAGE_ID of its own; one
// without does not compile.
#pragma once

#include "app/journal/entry.hpp"
#include "gateway/event.hpp"

namespace mbgate::app {

/// The names are taken from the settings.
Topic topic_of(const gateway::Event& event, const gateway::Settings& settings);

}  // namespace mbgate::app
