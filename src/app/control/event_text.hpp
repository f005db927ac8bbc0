// SPDX-License-Identifier: Apache-2.0
// Events as text: server-sent events (text/event-stream, in the HTML standard), with data in JSON
// (docs/api.yaml).
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "app/control/event_ring.hpp"

namespace mbgate::app {

/// "id: 7", "event: journal" and "data: {...}", a line each, and the empty line that ends it.
std::string event_text(const JournalEvent& event);

/// "id: 7", "event: NAME" and "data: DATA"; `data` has no line ends.
std::string server_event(std::uint64_t id, std::string_view name, std::string_view data);

/// Says that so many events are missing. It has no id: whoever comes back still names the last one
/// that it had.
std::string lost_text(std::uint64_t lost);

}  // namespace mbgate::app
