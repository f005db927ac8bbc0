// SPDX-License-Identifier: Apache-2.0
// What a bus counts. Plain numbers since the start; whoever shows them takes differences.
#pragma once

#include <cstdint>

namespace mbgate::bus {

struct BusCounters {
  std::uint64_t transmissions = 0;       ///< frames sent, broadcasts and retries included
  std::uint64_t broadcasts = 0;          ///< frames sent to nobody in particular
  std::uint64_t retries = 0;             ///< transmissions that were repeated
  std::uint64_t responses = 0;           ///< valid answers, exceptions included
  std::uint64_t exceptions = 0;          ///< answers that are exceptions of the device
  std::uint64_t timeouts = 0;            ///< transmissions without a valid answer
  std::uint64_t bad_crcs = 0;            ///< answers of the right shape with a wrong CRC or LRC
  std::uint64_t unsolicited_frames = 0;  ///< good frames that answer nothing that was asked
  std::uint64_t stray_bytes = 0;      ///< bytes that were no frame, or came while nothing was asked
  std::uint64_t noise_bytes = 0;      ///< skipped before frames: drivers turning on, glitches
  std::uint64_t echo_mismatches = 0;  ///< own transmissions that were heard differently
  std::uint64_t expired = 0;          ///< requests whose deadline passed
  std::uint64_t refused_full = 0;     ///< requests refused because the queue was full
  std::uint64_t losses = 0;           ///< times the line was lost
  std::uint64_t late_responses = 0;   ///< answers of devices that owed one
  std::uint64_t early_responses = 0;  ///< taken, though they began before their time
  std::uint64_t foreign_frames = 0;   ///< good frames of devices that owed nothing
  std::uint64_t shared_reads = 0;     ///< requests answered by another's transmission
  std::uint64_t merged_reads = 0;     ///< of these, those answered by a part of a longer read
  std::uint64_t cached_reads = 0;     ///< requests answered from memory
  std::uint64_t stops = 0;            ///< stops that were sent, repetitions included
  std::uint64_t stops_unanswered = 0;  ///< stops given up without a fitting echo
  std::uint64_t overtaken_writes = 0;  ///< writes taken back because of a stop
  std::uint64_t probes = 0;            ///< requests let through to offline devices
  std::uint64_t refused_offline = 0;   ///< requests refused because their device was offline
  std::uint64_t evicted = 0;           ///< waiting reads that lost their place in a full queue
};

struct DeviceCounters {
  std::uint64_t transmissions = 0;
  std::uint64_t responses = 0;
  std::uint64_t exceptions = 0;
  std::uint64_t timeouts = 0;
  std::uint64_t bad_crcs = 0;
  std::uint64_t late_responses = 0;
  std::uint64_t early_responses = 0;
  std::uint64_t noise_bytes = 0;  ///< skipped before its answers
};

}  // namespace mbgate::bus
