// SPDX-License-Identifier: Apache-2.0
// The record of one request in a trace, from the client to the wire and back: plain values with
// names, which can be read on another thread and after a reload.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "bus/job.hpp"
#include "bus/settings.hpp"
#include "gateway/client.hpp"

namespace mbgate::gateway {

using ByteString = std::vector<std::uint8_t>;

/// Bytes that came from a line together.
struct HeardBytes {
  Instant at;
  ByteString bytes;
};

/// One frame on a line, and what came back.
struct WireTrace {
  enum class Outcome : std::uint8_t {
    answered,     ///< with the response
    sent,         ///< nobody answers: a broadcast, or a write that its device never answers
    no_response,  ///< nothing that answers it came in time
    damaged,      ///< a response with a wrong CRC or LRC
    cut,          ///< the line was lost, or the gateway has given it up
    unasked       ///< nothing was sent: bytes were heard outside any transaction
  };

  std::string bus;
  std::string device;  ///< empty: the configuration has none at this address
  bus::Framing framing = bus::Framing::rtu;
  std::uint8_t address = 0;   ///< as in the frame
  unsigned tries = 0;         ///< transmissions of the same so far, this one included
  std::size_t shared_by = 1;  ///< requests that this frame answers
  Instant sent_at;
  ByteString frame;
  std::vector<HeardBytes> heard;
  std::size_t not_kept = 0;            ///< bytes that were heard beyond those
  std::optional<ByteString> response;  ///< the PDU that was taken
  Outcome outcome = Outcome::cut;
  Instant ended_at;
  /// Of a serial line, where something was sent: since when the line had been silent, and when the
  /// frame had left it.
  std::optional<Instant> silent_since;
  std::optional<Instant> left_at;
  /// No response: the device gets nothing but stops and the same read until then, or until the late
  /// answers have come.
  std::optional<Instant> held_until;
};

/// The client's side of a request.
struct AskedTrace {
  ClientId connection{};
  routing::ClientAddress client;
  std::string listener;
  Instant asked_at;    ///< where reading had been paused: since then
  ByteString request;  ///< the ADU as it came
  /// Where it is to go.
  struct Target {
    std::string bus;
    std::string device;  ///< empty: the configuration has none at the address
    friend bool operator==(const Target&, const Target&) = default;
  };
  std::vector<Target> targets{};
  Instant answered_at{};               ///< with `ordered` it is sent behind those before it
  std::optional<ByteString> answer{};  ///< nothing: the client has gone, or gets none
  bool refused = false;                ///< answered by the gateway without asking a device
};

struct TraceRecord {
  /// Nothing: bytes that nobody had asked for, or the frame of a request that was not traced from
  /// its beginning, or of a failsafe write.
  std::optional<AskedTrace> asked;
  std::vector<WireTrace> wire;          ///< in their order
  std::size_t wire_not_kept = 0;        ///< frames beyond those
  std::optional<bus::Ending> ended_as;  ///< its last job, or the first that failed

  /// The client got an exception, or nothing although no broadcast was sent for it, or something on
  /// the wire failed.
  [[nodiscard]] bool is_failed() const;
};

}  // namespace mbgate::gateway
