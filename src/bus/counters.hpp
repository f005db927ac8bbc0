// SPDX-License-Identifier: Apache-2.0
// What a bus counts: plain totals. A display that wants rates takes differences.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <functional>

#include "bus/instant.hpp"

namespace mbgate::bus {

struct BusCounters {
  std::uint64_t transmissions = 0;       ///< frames sent, broadcasts and retries included
  std::uint64_t broadcasts = 0;          ///< broadcast frames sent
  std::uint64_t retries = 0;             ///< transmissions that were repeated
  std::uint64_t responses = 0;           ///< valid answers, exceptions included
  std::uint64_t exceptions = 0;          ///< answers that are exceptions of the device
  std::uint64_t timeouts = 0;            ///< transmissions without a valid answer
  std::uint64_t bad_crcs = 0;            ///< answers of the right shape with a wrong CRC or LRC
  std::uint64_t unsolicited_frames = 0;  ///< valid frames that answer no pending request
  std::uint64_t stray_bytes = 0;      ///< bytes outside any frame, or while no request was pending
  std::uint64_t noise_bytes = 0;      ///< skipped before frames: line drivers turning on, glitches
  std::uint64_t echo_mismatches = 0;  ///< own transmissions whose echo differed
  std::uint64_t expired = 0;          ///< requests whose deadline passed
  std::uint64_t refused_full = 0;     ///< requests refused because the queue was full
  std::uint64_t losses = 0;           ///< times the line was lost
  std::uint64_t late_responses = 0;   ///< late answers to requests that had timed out
  std::uint64_t early_responses = 0;  ///< accepted, though they began before response_wait was over
  std::uint64_t foreign_frames =
      0;  ///< requests of other clients, frames of devices that owed no answer
  std::uint64_t shared_reads = 0;      ///< requests answered by the transmission of another request
  std::uint64_t cached_reads = 0;      ///< reads answered from the cache
  std::uint64_t stops = 0;             ///< stops that were sent, repetitions included
  std::uint64_t stops_unanswered = 0;  ///< stops given up without being acknowledged
  std::uint64_t overtaken_writes = 0;  ///< waiting writes cancelled by a stop
  std::uint64_t probes = 0;            ///< requests sent to offline devices as probes
  std::uint64_t refused_offline = 0;   ///< requests refused because their device was offline
  std::uint64_t evicted = 0;           ///< waiting reads dropped from a full queue
};

/// Exceptions by their code.
class ExceptionCounts {
 public:
  /// The last code of the specification (Application Protocol V1.1b3, section 7).
  static constexpr std::uint8_t kLastCode = 0x0B;

  void note(std::uint8_t code) { ++counts_[place_of(code)]; }
  void add(const ExceptionCounts& others) {
    std::ranges::transform(counts_, others.counts_, counts_.begin(), std::plus());
  }
  /// Codes beyond the last, those of makers, are counted together: it is the same for all of them.
  [[nodiscard]] std::uint64_t of(std::uint8_t code) const { return counts_[place_of(code)]; }
  [[nodiscard]] std::uint64_t others() const { return counts_[0]; }

 private:
  static constexpr std::size_t place_of(std::uint8_t code) {
    return code <= kLastCode ? code : std::size_t{0};
  }

  std::array<std::uint64_t, kLastCode + 1> counts_{};
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
  ExceptionCounts exceptions_by_code;
  Duration wire_time{0};  ///< its requests and their answers, or the wait for them, had the line
};

}  // namespace mbgate::bus
