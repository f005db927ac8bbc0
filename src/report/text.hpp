// SPDX-License-Identifier: Apache-2.0
// What people read of events, of clients and their requests, and of traces.
//
// To change
// - the line of an event: event_text; of a request or a certificate: asked_text.
// - the bytes of a trace in words: trace_text.
#pragma once

#include <string>

#include "gateway/event.hpp"
#include "gateway/trace/trace_record.hpp"

namespace mbgate::report {

/// One line for the journal. The names are taken from the settings.
std::string to_text(const gateway::Event& event, const gateway::Settings& settings);

/// ` (role "operator", certificate "panel 3")`; of a client without a certificate nothing.
std::string identity_text(const gateway::Asker& asker);

/// "function 16 at unit 1, holding registers 100..103 = 5 0 0 7": the addresses are those of the
/// client, the values decimal, and not more of them than an operator can make use of.
std::string request_text(const gateway::Asked& asked);

// The bytes of a trace in one line, with their faults.

/// "answered", "no response"
const char* to_text(gateway::WireTrace::Outcome outcome);
/// How a request ended: "its deadline had passed", "the device is offline". `was_sent`: something
/// of it was on the wire.
const char* to_text(bus::Ending ending, bool was_sent);

/// "unit 1: read holding registers 30..31"
std::string sent_text(const gateway::WireTrace& wire);
/// "2 registers: 0x0003 0x0D40", "CRC FF FF, B5 33 would be right", "nothing". On a line with an
/// echo: "the same bytes as sent, then 1 register: 0x0003".
std::string heard_text(const gateway::WireTrace& wire);

}  // namespace mbgate::report
