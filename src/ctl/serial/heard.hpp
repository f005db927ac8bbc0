// SPDX-License-Identifier: Apache-2.0
// The bytes that were heard on a serial line after one read. It has no port and no clock.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "modbus/bytes.hpp"
#include "modbus/frames.hpp"
#include "modbus/request.hpp"

namespace mbgate::ctl {

enum class HeardKind : std::uint8_t {
  silence,
  answer,       ///< of the unit that was asked: data, or an exception
  other_frame,  ///< whole, but of another unit, or to another request
  bad_crc,      ///< begins as the answer does
  noise         ///< bytes that are no frame
};

struct Heard {
  HeardKind kind = HeardKind::silence;
  std::size_t bytes = 0;                  ///< all that came; with an echo, what came behind it
  std::uint8_t unit = 0;                  ///< of `other_frame`
  std::optional<modbus::Pdu> response{};  ///< of `answer`
  std::chrono::nanoseconds took{0};       ///< from the first byte sent to the last one heard
};

/// A read as it goes out. There is no other request, so that a scan cannot write.
class SentRead {
 public:
  SentRead(std::uint8_t unit, const modbus::TableRange& read);

  [[nodiscard]] modbus::Bytes frame() const { return {frame_.data(), frame_.size()}; }
  /// Where the request itself stands in what was received, if the port receives what it sends.
  /// Before it there may be what a transceiver makes of turning round.
  [[nodiscard]] std::optional<std::size_t> echo_in(modbus::Bytes received) const;
  /// The answer in what was received so far, behind an echo if there is one. Around it there may be
  /// other bytes: a late answer of another unit, and what a transceiver makes of turning round.
  [[nodiscard]] std::optional<modbus::Pdu> answer_in(modbus::Bytes received) const;
  /// What all that was received means; `took` is not set.
  [[nodiscard]] Heard understand(modbus::Bytes received) const;

 private:
  [[nodiscard]] modbus::Bytes behind_echo(modbus::Bytes received) const;
  [[nodiscard]] std::optional<modbus::Pdu> answer_at_begin(modbus::Bytes received) const;

  std::uint8_t unit_;
  modbus::Request request_;
  modbus::RtuBytes frame_;
};

// The whole RTU frames in bytes that were heard, wherever they begin. Only those of functions that
// determine their length are known: without it nothing tells a frame from noise.

/// So many bytes an adapter or a transceiver makes up, when it is switched on or turns round. More
/// of them may be what is left of another client's frames.
inline constexpr std::size_t kFewBytes = 2;

enum class FrameKind : std::uint8_t {
  request,
  response,
  either  ///< some writes are acknowledged by themselves
};

struct BusFrame {
  std::size_t begin;
  std::size_t size;
  std::uint8_t unit;
  FrameKind kind;
  friend bool operator==(const BusFrame&, const BusFrame&) = default;
};

struct BusFrames {
  std::vector<BusFrame> frames{};
  std::size_t stray = 0;  ///< bytes that belong to none
};

BusFrames find_frames(modbus::Bytes heard);

}  // namespace mbgate::ctl
