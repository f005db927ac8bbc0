// SPDX-License-Identifier: Apache-2.0
// What the journal says of events, and of clients and their requests.
//
// To change
// - the line of an event: event_text; of a request or a certificate: asked_text.
// - the bytes of a trace in words: trace_text.
#pragma once

#include <string>

#include "gateway/event.hpp"

namespace mbgate::report {

/// One line for the journal. The names are taken from the settings.
std::string to_text(const gateway::Event& event, const gateway::Settings& settings);

/// ` (role "operator", certificate "panel 3")`; of a client without a certificate nothing.
std::string identity_text(const gateway::Asker& asker);

/// "function 16 at unit 1, holding registers 100..103 = 5 0 0 7": the addresses are those of the
/// client, the values decimal, and not more of them than an operator can make use of.
std::string request_text(const gateway::Asked& asked);

}  // namespace mbgate::report
