// SPDX-License-Identifier: Apache-2.0
// Describes the bytes of a trace in one line for people, with their faults.
#pragma once

#include <string>

#include "gateway/trace/trace_record.hpp"

namespace mbgate::report {

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
