// SPDX-License-Identifier: Apache-2.0
// Finds requests in the bytes from a pty, where the silence on the wire cannot be seen. A request
// with a known function ends by its length and CRC, at once. Anything else ends by a silence that
// is longer than any scheduling delay. Pure; only the simulator in real time needs it.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <vector>

#include "bus/instant.hpp"
#include "modbus/bytes.hpp"
#include "modbus/frames.hpp"

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

/// The two framings of an ADU on a serial line, RTU and ASCII, for a simulated bus.
enum class Framing : std::uint8_t { rtu, ascii };

/// Long enough for either: an ASCII frame is the longer one.
using FrameBytes = modbus::AsciiBytes;

FrameBytes encode_frame(Framing framing, std::uint8_t address, const modbus::Pdu& pdu);

/// The frame's parts; nothing if it is damaged.
std::optional<modbus::RtuAdu> decode_frame(Framing framing, modbus::Bytes frame);

/// Makes the CRC or LRC of a frame wrong and changes nothing else.
void spoil_check(Framing framing, FrameBytes& frame);

// Finds ASCII frames among the characters on a line: from ':' to LF; another ':' begins anew, and a
// second of silence or too many characters end the attempt (Serial Line V1.02, 2.5.2 and figure
// 15). Characters between frames are noise. Pure: instants are handed in.

/// Longest silence between two characters of a frame.
inline constexpr bus::Duration kAsciiCharacterTimeout = std::chrono::seconds(1);

struct AsciiFrame {
  std::vector<std::uint8_t> bytes;
  bus::Instant begin;  ///< of its ':'
  bus::Instant end;    ///< of its last character
};

class AsciiFramer {
 public:
  /// Takes a character that was on the line from `begin` to `end`. Returns the frame that it ends:
  /// one that is complete with this LF, or one that is given up before it.
  std::optional<AsciiFrame> feed(std::uint8_t character, bus::Instant begin, bus::Instant end);
  void clear() { frame_.bytes.clear(); }

 private:
  AsciiFrame frame_;  ///< without bytes: none has begun
};

}  // namespace mbgate::sim
