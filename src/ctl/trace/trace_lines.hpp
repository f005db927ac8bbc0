// SPDX-License-Identifier: Apache-2.0
// A record of a trace as lines for people, suited to grep: failures have the word FAILED.
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
/// The request's own failure, not that of one of its frames: "exception 0x0B (gateway target device
/// failed to respond): no valid answer came", or nothing. A broadcast may be answered by nobody.
std::string request_failure(const TraceEvent& event);

/// What was not kept, for want of room: "and 2 bytes more".
std::string and_more(std::uint64_t not_kept, const std::string& what);

}  // namespace mbgate::ctl
