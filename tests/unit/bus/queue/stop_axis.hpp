// SPDX-License-Identifier: Apache-2.0
// An axis with one stop, and a move that is none.
#pragma once

#include "bus/settings.hpp"
#include "drive/device.hpp"

namespace mbgate::test {

inline constexpr auto kStop = "06 007C 00E1";
inline constexpr auto kStopFrame = "01 06 00 7C 00 E1 88 5A";
inline constexpr auto kStopBy16 = "10 007C 0001 02 00E1";  // not identical to the other
inline constexpr auto kMove = "06 007C 0066";
inline constexpr auto kMoveFrame = "01 06 00 7C 00 66 C8 38";

inline drive::Device axis(const bus::BusSettings& settings, std::uint8_t address = 1) {
  drive::Device device{"axis", {}, address, settings.timing};
  device.profile.stops = {{.address = 0x007C, .value = 0x00E1}};
  return device;
}

}  // namespace mbgate::test
