// SPDX-License-Identifier: Apache-2.0
// What a bus counts. Plain numbers since the start; whoever shows them takes differences.
#pragma once

#include <cstdint>

namespace mbgate::bus {

struct BusCounters {
  std::uint64_t transmissions = 0;    ///< frames sent, broadcasts and retries included
  std::uint64_t broadcasts = 0;       ///< frames sent to nobody in particular
  std::uint64_t retries = 0;          ///< reads that were repeated
  std::uint64_t responses = 0;        ///< valid answers, exceptions included
  std::uint64_t exceptions = 0;       ///< answers that are exceptions of the device
  std::uint64_t timeouts = 0;         ///< transmissions without a valid answer
  std::uint64_t bad_crcs = 0;         ///< answers of the right shape with a wrong CRC or LRC
  std::uint64_t stray_frames = 0;     ///< good frames that answer nothing that was asked
  std::uint64_t stray_bytes = 0;      ///< bytes that were no frame, or came while nothing was asked
  std::uint64_t noise_bytes = 0;      ///< leading 00 or FF bytes of drivers turning on
  std::uint64_t echo_mismatches = 0;  ///< own transmissions that were heard differently
  std::uint64_t expired = 0;          ///< requests whose deadline passed
  std::uint64_t refused_full = 0;     ///< requests refused because the queue was full
  std::uint64_t losses = 0;           ///< times the line was lost
};

struct DeviceCounters {
  std::uint64_t transmissions = 0;
  std::uint64_t responses = 0;
  std::uint64_t exceptions = 0;
  std::uint64_t timeouts = 0;
  std::uint64_t bad_crcs = 0;
  std::uint32_t unanswered_in_row = 0;
};

}  // namespace mbgate::bus
