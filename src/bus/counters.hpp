// SPDX-License-Identifier: Apache-2.0
// The counters of a bus: plain totals. A display of rates takes differences.
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

/// Where a counter of a bus is shown.
struct CounterKind {
  std::uint64_t BusCounters::*member;
  const char* name;              ///< in the status as JSON
  unsigned place;                ///< among the counters of unit 255
  const char* help;              ///< of the metric
  const char* metric = name;     ///< mbgate_bus_NAME_total
  const char* reason = nullptr;  ///< where several counters are one metric, by reason
};
inline constexpr const char* kRefused = "refused_requests";
inline constexpr const char* kRefusedHelp =
    "Requests that were never sent, or not again, by reason.";
/// In unit 255 no counter has place 18 any more.
inline constexpr unsigned kCounterPlaces = 26;
inline constexpr auto kBusCounters = std::to_array<CounterKind>({
    {&BusCounters::transmissions, "transmissions", 0,
     "Frames sent, broadcasts and repetitions included."},
    {&BusCounters::broadcasts, "broadcasts", 13, "Broadcasts sent."},
    {&BusCounters::retries, "retries", 12, "Requests sent again."},
    {&BusCounters::responses, "responses", 1, "Valid responses, exceptions included."},
    {&BusCounters::exceptions, "exceptions", 2, "Responses that are exceptions of the device."},
    {&BusCounters::timeouts, "timeouts", 3, "Transmissions without a valid response."},
    {&BusCounters::bad_crcs, "bad_crcs", 4, "Responses with a wrong CRC or LRC.", "crc_errors"},
    {&BusCounters::late_responses, "late_responses", 14, "Responses after their timeout."},
    {&BusCounters::early_responses, "early_responses", 15,
     "Responses before response_wait was over."},
    {&BusCounters::unsolicited_frames, "unsolicited_frames", 5,
     "Valid frames that answer no pending request."},
    {&BusCounters::foreign_frames, "foreign_frames", 16,
     "Requests of other clients on the line, and frames of devices that owed none."},
    {&BusCounters::stray_bytes, "stray_bytes", 6, "Bytes that belong to no frame."},
    {&BusCounters::noise_bytes, "noise_bytes", 7, "Bytes skipped before frames."},
    {&BusCounters::echo_mismatches, "echo_mismatches", 8,
     "Transmissions that were heard differently than they were sent."},
    {&BusCounters::expired, "expired", 9, kRefusedHelp, kRefused, "deadline"},
    {&BusCounters::refused_full, "refused_full", 10, kRefusedHelp, kRefused, "queue_full"},
    {&BusCounters::refused_offline, "refused_offline", 24, kRefusedHelp, kRefused,
     "device_offline"},
    {&BusCounters::evicted, "evicted", 25, kRefusedHelp, kRefused, "evicted"},
    {&BusCounters::losses, "losses", 11, "How often the line was lost."},
    {&BusCounters::shared_reads, "shared_reads", 17,
     "Reads answered by the transmission of another request."},
    {&BusCounters::cached_reads, "cached_reads", 19, "Reads answered from the cache."},
    {&BusCounters::stops, "stops", 20, "Stops sent, repetitions included."},
    {&BusCounters::stops_unanswered, "stops_unanswered", 21,
     "Stops given up without being acknowledged."},
    {&BusCounters::overtaken_writes, "overtaken_writes", 22, "Waiting writes cancelled by a stop."},
    {&BusCounters::probes, "probes", 23, "Requests sent to offline devices as probes."},
});

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
