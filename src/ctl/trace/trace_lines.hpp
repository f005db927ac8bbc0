// SPDX-License-Identifier: Apache-2.0
// A record of a trace as lines for people, which grep finds things in: what failed has the word
// FAILED.
#pragma once

#include <cstdint>
#include <string>

#include "ctl/trace/trace_event.hpp"

namespace mbgate::ctl {

/// With a newline behind each line; the times are local ones.
std::string trace_lines(const TraceEvent& event);

/// "3 records are missing here: ..."
std::string missing_records(std::uint64_t lost);

/// What went wrong: "CRC FF FF, B5 33 would be right", "nothing within 300.0 ms"; empty if nothing
/// did. Bytes that nobody had asked for are no failure by themselves.
std::string failure_of(const TracedFrame& frame);
/// "exception 0x0B (gateway target device failed to respond): no valid answer came", or nothing.
std::string failure_of(const TracedRequest& asked);
/// The request's, else the first of its frames'.
std::string failure_of(const TraceEvent& event);

}  // namespace mbgate::ctl
