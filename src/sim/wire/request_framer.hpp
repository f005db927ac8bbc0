// SPDX-License-Identifier: Apache-2.0
// Finds requests in the bytes that come out of a pty, where silence on the wire is not to be seen:
// a known function by its length and CRC, at once; anything else by a silence that no scheduler
// produces. Pure; only the simulator in real time needs it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bus/instant.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::sim {

using bus::Duration;
using bus::Instant;

/// How long the RTU request frame that begins with `prefix` is, CRC included; nothing if its
/// function does not say, or too little has come. Knows the AiC's broadcast functions too.
std::optional<std::size_t> request_frame_length(modbus::Bytes prefix);

struct ReceivedFrame {
  std::vector<std::uint8_t> bytes;
  Instant begin;  ///< when its first byte came
};

class RequestFramer {
 public:
  /// `silence` ends whatever cannot be recognised.
  explicit RequestFramer(Duration silence) : silence_(silence) {}

  void feed(modbus::Bytes bytes, Instant now);
  /// The next frame that is whole, or that silence has ended. Call it until there is none.
  std::optional<ReceivedFrame> poll(Instant now);
  /// When silence will end what is left over.
  [[nodiscard]] std::optional<Instant> deadline() const;
  void clear() { bytes_.clear(); }

 private:
  Duration silence_;
  std::vector<std::uint8_t> bytes_;
  Instant begin_{};
  Instant last_{};
};

}  // namespace mbgate::sim
