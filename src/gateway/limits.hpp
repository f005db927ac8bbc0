// SPDX-License-Identifier: Apache-2.0
// Every fixed limit of the machine, each with its reason. What a user may want to change is a
// setting instead.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>

#include "bus/instant.hpp"

namespace mbgate::gateway {

/// Bytes a connection is read ahead while its pipeline is full: enough to see what is coming, too
/// few to matter with 10,000 connections.
inline constexpr std::size_t kReadAhead = 4096;

/// The driver reads a socket in pieces of at most this size: one more always fits into the
/// read-ahead.
inline constexpr std::size_t kClientReadSize = 2048;

/// Arrival times kept of bytes read ahead. Beyond that, later bytes count as old as the last kept
/// piece, which errs to the safe side: a request can only look older than it is.
inline constexpr std::size_t kArrivalMarks = 32;

/// Stops of a connection that may lie taken behind requests that were not: more than a hand presses
/// a button while a pipeline is stuck, too few to crowd out other clients' stops.
inline constexpr std::size_t kStopReserve = 16;

/// Reads wait this long for their turn unless the route says otherwise: longer than any screen
/// waits.
inline constexpr bus::Duration kReadDeadline = std::chrono::seconds(5);

/// Writes wait 1 s, or twice the longest response timeout of the bus so that one silent device does
/// not cost them their turn; not longer, because an old motion command is dangerous.
constexpr bus::Duration write_deadline(bus::Duration longest_response_timeout) {
  return std::max<bus::Duration>(std::chrono::seconds(1), 2 * longest_response_timeout);
}

/// After a shutdown was asked for, what is on the wire has this long: the process ends within 2 s.
inline constexpr bus::Duration kShutdownGrace = std::chrono::milliseconds(1500);

}  // namespace mbgate::gateway
