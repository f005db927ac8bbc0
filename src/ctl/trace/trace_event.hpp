// SPDX-License-Identifier: Apache-2.0
// One record of a trace as mbgated sends it (docs/api.yaml): a request from the client to the wire
// and back, a frame for no request that is traced, or bytes that nobody had asked for.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "modbus/bytes.hpp"

namespace mbgate::ctl {

using ByteString = std::vector<std::uint8_t>;
inline void append(ByteString& bytes, modbus::Bytes more) {
  bytes.insert(bytes.end(), more.begin(), more.end());
}
/// Of the day, in UTC.
using TraceInstant = std::chrono::sys_time<std::chrono::microseconds>;

/// Bytes that were sent or came together.
struct TracedBytes {
  TraceInstant at;
  ByteString bytes;
};

/// `text`: what they mean, in one line.
struct TracedAdu {
  TracedBytes raw;
  std::string text;
};

enum class TracedFraming : std::uint8_t { rtu, ascii, tcp };
enum class TracedOutcome : std::uint8_t { answered, sent, no_response, damaged, cut, unasked };

/// One frame on a line, and what came back.
struct TracedFrame {
  std::string bus;
  std::string device;  ///< empty: the configuration has none at this address
  std::uint8_t address = 0;
  TracedFraming framing = TracedFraming::rtu;
  std::optional<TracedAdu> sent;  ///< nothing: heard without a request
  std::uint64_t tries = 0;        ///< this one included
  std::uint64_t shared_by = 0;    ///< requests that this frame answers
  std::vector<TracedBytes> heard;
  std::uint64_t not_kept = 0;  ///< bytes that were heard beyond those
  std::string heard_text;
  std::optional<ByteString> response;  ///< the PDU that was taken
  TracedOutcome outcome = TracedOutcome::cut;
  TraceInstant ended_at;
};

/// The client's side.
struct TracedRequest {
  std::string client;  ///< its IP address
  std::uint64_t connection = 0;
  std::string listener;
  TracedAdu request;
  std::optional<TracedAdu> answer;  ///< nothing: the client has gone, or gets none
  bool refused = false;             ///< answered by the gateway without asking a device
  std::string ended;                ///< how its last job ended; empty: it had none
};

struct TraceEvent {
  bool failed = false;
  std::optional<TracedRequest> asked;
  std::vector<TracedFrame> wire;
  std::uint64_t wire_not_kept = 0;  ///< frames beyond those
};

/// `data`: that of an event. An exception says what is not as mbgated sends it.
TraceEvent parse_trace(const std::string& data);

/// All bytes that were heard, one behind the other.
ByteString all_heard(const TracedFrame& frame);

/// A record of a trace as lines for people, suited to grep: failures have the word FAILED. With a
/// newline behind each line; the times are local ones.
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
