// SPDX-License-Identifier: Apache-2.0
// The whole RTU frames in bytes that were heard, wherever they begin. Only those of functions that
// determine their length are known: without it nothing tells a frame from noise.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "modbus/bytes.hpp"

namespace mbgate::ctl {

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
