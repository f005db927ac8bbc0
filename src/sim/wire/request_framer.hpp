// SPDX-License-Identifier: Apache-2.0
// Finds requests in the bytes from a pty, where the silence on the wire cannot be seen. A request
// with a known function ends by its length and CRC, at once. Anything else ends by a silence that
// is longer than any scheduling delay. Pure; only the simulator in real time needs it.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "bus/instant.hpp"
#include "modbus/bytes.hpp"

namespace mbgate::sim {

using bus::Duration;
using bus::Instant;

/// The length of the RTU request frame that begins with `prefix`, CRC included. Nothing if its
/// function does not determine it, or too little has come. Knows the AiC's broadcast functions too.
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
  /// The next frame that is complete, or that silence has ended. Call it until there is none.
  std::optional<ReceivedFrame> poll(Instant now);
  /// When silence will end what is left.
  [[nodiscard]] std::optional<Instant> deadline() const;
  void clear() { bytes_.clear(); }

 private:
  Duration silence_;
  std::vector<std::uint8_t> bytes_;
  Instant begin_{};
  Instant last_{};
};

}  // namespace mbgate::sim
